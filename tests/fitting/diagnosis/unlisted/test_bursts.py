"""Friction that rises for moments is told from noise, from what falls as well and from what few runs have."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.lanes.jobs import predicted
from fitting.diagnosis.unlisted.bursts import Bursts, bursts
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Run
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out
from tests.fitting.reference_data import TRUTH, dataset, noisy, own_run

FREQUENCIES = (0.8, 1.1, 1.5, 2.6, 1.3, 2.0, 1.7)
PERIOD = 0.2175
HEIGHT, SHARE = 0.2, 0.06


def raised(run: Run, random: np.random.Generator, height: float, often: float = 1.0) -> Run:
    """The run with friction higher by a share of itself in moments of a quarter of a natural period."""
    assert run.friction is not None
    count, length = len(run.time), round(PERIOD / 4 / run.interval)
    factor = np.ones(count)
    for first in random.integers(0, count - length, round(often * SHARE * count / length)):
        factor[first : first + length] = 1 + height
    return dataclasses.replace(run, friction=factor * run.friction)


def found_in(heights: tuple[float, ...], falls: float = 0.0) -> Bursts | None:
    """What is found where friction rises by these shares in runs of the 1987 rig, and falls so many times as
    often as it rises; the constants are true."""
    random = np.random.default_rng(5)
    runs = []
    for number, (frequency, height) in enumerate(zip(FREQUENCIES, heights, strict=False)):
        run = own_run(SineDrive(frequency, 10.325e-3), samples=1500, file=f"run-{number}.csv")
        run = raised(run, random, height)
        runs.append(noisy(raised(run, random, -height, falls), random))
    model, bench = laid_out(dataset(*runs))
    point = from_the_truth(model, bench, (), model.origin(TRUTH)).point
    return bursts(bench, predicted(model, bench, point), PERIOD)


def test_moments_of_higher_friction_are_found_with_their_height_and_share():
    found = found_in((HEIGHT,) * 4)
    assert found is not None
    assert (found.runs, found.of) == (4, 4)
    assert found.height == pytest.approx(HEIGHT, rel=0.25)
    assert 0.5 * SHARE < found.share < 1.5 * SHARE


@pytest.mark.parametrize(
    ("heights", "falls"),
    [
        pytest.param((0.0,) * 4, 0.0, id="noise alone"),
        pytest.param((HEIGHT,) * 4, 1.0, id="it falls as often as it rises"),
        pytest.param((HEIGHT, 0.0, HEIGHT), 0.0, id="in two runs only"),
        pytest.param((HEIGHT, 0.0) * 3, 0.0, id="in no more than half of the runs"),
        pytest.param((HEIGHT,) * 4 + (-HEIGHT,) * 2, 0.0, id="it falls in other runs"),
    ],
)
def test_what_else_strays_is_no_burst(heights, falls):
    assert found_in(heights, falls) is None


def test_three_runs_of_four_are_enough():
    found = found_in((HEIGHT, 0.0, HEIGHT, HEIGHT))
    assert found is not None and (found.runs, found.of) == (3, 4)


def test_it_may_seldom_fall_as_far():
    found = found_in((HEIGHT,) * 4, falls=0.2)
    assert found is not None and found.runs >= 3


def test_what_rises_is_said_with_its_height_and_how_often():
    rises = Bursts(5, 6, 0.023, 0.12)
    assert rises.clause.startswith("friction rises for moments, by 12 % in 5 of 6 runs")
    assert "by 12 % of itself in 2.3 % of the time of fast sliding" in rises.note
