"""Friction that jumps is told from noise, from friction that scatters, and from what a wrong model leaves."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from fitting.diagnosis.lanes.jobs import predicted
from fitting.diagnosis.unlisted.jumps import Jumps, jumps
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out
from tests.fitting.reference_data import TRUTH, dataset, noisy, own_run

FREQUENCIES = (0.8, 1.1, 1.5, 2.6, 1.3, 2.0)
HEIGHT, LENGTH = 0.06, 40
MEMORY = 60
Factor = Callable[[int, np.random.Generator], np.ndarray]


def raised(samples: int, random: np.random.Generator) -> np.ndarray:
    """Twenty moments of higher friction, which begin and end within a sample."""
    factor = np.ones(samples)
    for first in random.integers(0, samples - LENGTH, 20):
        factor[first : first + LENGTH] = 1 + HEIGHT
    return factor


def spiked(samples: int, random: np.random.Generator) -> np.ndarray:
    """Single samples that are off, one in forty."""
    factor = np.ones(samples)
    factor[20::40] += 4 * HEIGHT
    return factor


def scattered(samples: int, random: np.random.Generator, deviation: float = HEIGHT) -> np.ndarray:
    """Friction that scatters by as much as it jumps elsewhere, with a memory of half a natural period."""
    keeps = np.exp(-1 / MEMORY)
    steps = deviation * np.sqrt(1 - keeps**2) * random.standard_normal(samples)
    return 1 + np.asarray(lfilter([1.0], [1.0, -keeps], steps))


def swelling(samples: int, random: np.random.Generator) -> np.ndarray:
    """As many moments of higher friction, which begin and end in a tenth of a natural period."""
    return 1 + np.convolve(raised(samples, random) - 1, np.full(12, 1 / 12), mode="same")


def both(samples: int, random: np.random.Generator) -> np.ndarray:
    """It jumps, and scatters by a third of that."""
    return raised(samples, random) * scattered(samples, random, HEIGHT / 3)


def steady(samples: int, random: np.random.Generator) -> np.ndarray:
    return np.ones(samples)


def found_in(factor: Factor, of: int = 6, *, recorded: bool = True, wrong: float = 1.0) -> Jumps | None:
    """What is found where friction is so many times what it should be in the first `of` six runs of the 1987
    rig; the constants are true, but for friction that is `wrong` by a factor."""
    random = np.random.default_rng(5)
    made = []
    for number, frequency in enumerate(FREQUENCIES):
        run = own_run(SineDrive(frequency, 10.325e-3), samples=1500, file=f"run-{number}.csv")
        assert run.friction is not None
        if number < of:
            run = dataclasses.replace(run, friction=factor(len(run.time), random) * run.friction)
        run = noisy(run, random)
        made.append(run if recorded else dataclasses.replace(run, friction=None))
    model, bench = laid_out(dataset(*made))
    assumed = {**TRUTH, "C": wrong * TRUTH["C"]}
    point = from_the_truth(model, bench, (), model.origin(assumed)).point
    return jumps(bench, predicted(model, bench, point))


@pytest.mark.parametrize("factor", [raised, both])
def test_jumps_are_found_with_their_height(factor):
    found = found_in(factor)
    assert found is not None
    assert found.runs >= 5 and found.of == 6 and found.count > 20
    assert found.height == pytest.approx(HEIGHT, rel=0.3)


def test_four_runs_of_six_are_enough():
    found = found_in(raised, of=4)
    assert found is not None and (found.runs, found.of) == (4, 6)


@pytest.mark.parametrize(
    ("factor", "of", "wrong"),
    [
        pytest.param(steady, 6, 1.0, id="noise alone"),
        pytest.param(scattered, 6, 1.0, id="it scatters"),
        pytest.param(swelling, 6, 1.0, id="it swells"),
        pytest.param(spiked, 6, 1.0, id="single samples are off"),
        pytest.param(raised, 3, 1.0, id="in no more than half of the runs"),
        pytest.param(steady, 6, 1.2, id="the model is wrong"),
    ],
)
def test_what_else_friction_does_is_no_jump(factor, of, wrong):
    assert found_in(factor, of, wrong=wrong) is None


def lanes_of(velocity: float = 1.0, modelled_jump: float = 0.0, level: float = 1.0) -> tuple[Any, Any]:
    """A bench of two lanes in which friction of 1 N jumps by HEIGHT under a model that keeps its level, or
    jumps as well; the mass slides fast in the first, and at this share of that speed where friction jumps,
    which is lower there by a factor, `level`."""
    random = np.random.default_rng(3)
    expected, speed = np.ones((2, 200)), np.ones((2, 200))
    expected[1] = level
    friction = expected + 0.002 * random.standard_normal((2, 200))
    friction[1, 100:] += HEIGHT
    expected[1, 100:] += modelled_jump
    speed[1] = velocity
    lanes = SimpleNamespace(friction=friction, friction_weight=np.ones((2, 200)))
    bench = SimpleNamespace(lanes=lanes, run=np.zeros(2, int))
    return bench, SimpleNamespace(friction=expected, velocity=speed)


def test_a_jump_is_one_of_the_record_while_the_mass_slides_fast():
    found = jumps(*lanes_of())
    assert found is not None and (found.count, found.runs, found.of) == (1, 1, 1)
    assert found.height == pytest.approx(HEIGHT, rel=0.05)
    assert jumps(*lanes_of(velocity=0.2)) is None
    assert jumps(*lanes_of(modelled_jump=2 * HEIGHT)) is None
    assert jumps(*lanes_of(modelled_jump=-HEIGHT)) is None
    assert jumps(*lanes_of(level=0.2)) is None


def test_without_a_friction_force_there_is_none_to_be_seen():
    assert found_in(raised, recorded=False) is None


def test_jumps_are_said_with_their_height_and_number():
    said = Jumps(9, 5, 6, 0.023)
    assert said.clause.startswith("friction jumps while the mass slides, by 2.3 % in 5 of 6 runs")
    assert said.note.startswith("In 5 of 6 runs friction jumps") and "9 times in all" in said.note
