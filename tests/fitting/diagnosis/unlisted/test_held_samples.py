"""A channel that repeats its last value is told from one that hardly changes, is late, or is coarse."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from fitting.diagnosis.lanes.jobs import predicted
from fitting.diagnosis.unlisted.held_samples import HeldSamples, held_samples
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Run
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out
from tests.fitting.reference_data import NOISE, TRUTH, dataset, noisy, own_run

FREQUENCIES = (0.8, 1.5, 2.6)
LENGTH = 8
Fault = Callable[[np.ndarray], np.ndarray]


def held(times: int, seed: int = 4) -> Fault:
    """So many stretches of eight samples that repeat the first of them."""
    random = np.random.default_rng(seed)

    def repeated(values: np.ndarray) -> np.ndarray:
        values = values.copy()
        for first in random.integers(0, len(values) - LENGTH, times):
            values[first : first + LENGTH] = values[first]
        return values

    return repeated


def held_once(values: np.ndarray) -> np.ndarray:
    """One such stretch, where the values change most in it."""
    first = int(np.argmax(np.abs(values[LENGTH:] - values[:-LENGTH])))
    values = values.copy()
    values[first : first + LENGTH] = values[first]
    return values


def late(values: np.ndarray) -> np.ndarray:
    return np.concatenate([np.full(3, values[0]), values[:-3]])


def coarse(values: np.ndarray) -> np.ndarray:
    """In steps of a twentieth of its range, which is many times the noise."""
    step = np.ptp(values) / 20
    return step * np.round(values / step)


def found_in(
    force: Fault | None,
    runs: int = 3,
    motion: Fault | None = None,
    converter: Fault | None = None,
    *,
    recorded: bool = True,
) -> HeldSamples | None:
    """What is found where these act on the channels of some of three runs of the 1987 rig, the converter on
    what the force is with its noise; the constants are true."""
    random = np.random.default_rng(5)
    made: list[Run] = []
    for number, frequency in enumerate(FREQUENCIES):
        run = own_run(SineDrive(frequency, 10.325e-3), samples=1500, file=f"run-{number}.csv")
        assert run.friction is not None
        if number < runs:
            friction = run.friction if force is None else force(run.friction)
            displacement = run.displacement if motion is None else motion(run.displacement)
            run = dataclasses.replace(run, friction=friction, displacement=displacement)
        run = noisy(run, random)
        if converter is not None and run.friction is not None:
            run = dataclasses.replace(run, friction=converter(run.friction))
        made.append(run if recorded else dataclasses.replace(run, friction=None))
    model, bench = laid_out(dataset(*made))
    point = from_the_truth(model, bench, (), model.origin(TRUTH)).point
    return held_samples(bench, predicted(model, bench, point))


def test_a_force_that_is_held_is_found():
    found = found_in(held(12))
    assert found is not None and (found.channel, found.of) == ("friction force", 3)
    assert found.runs >= 2 and found.count >= 3
    assert NOISE.friction is not None and found.most > 20 * NOISE.friction


def test_a_displacement_that_is_held_is_found_without_a_force_as_well():
    found = found_in(None, motion=held(12), recorded=False)
    assert found is not None and (found.channel, found.unit) == ("displacement", "m")


@pytest.mark.parametrize(
    ("force", "runs", "converter"),
    [
        pytest.param(None, 3, None, id="noise alone"),
        pytest.param(late, 3, None, id="it is late"),
        pytest.param(None, 3, coarse, id="it is coarse"),
        pytest.param(held_once, 1, None, id="it is held once"),
    ],
)
def test_what_else_stands_still_is_not_held(force, runs, converter):
    assert found_in(force, runs, converter=converter) is None


def test_what_is_held_is_said_with_how_often_and_how_far():
    held = HeldSamples("friction force", "N", 7, 3, 6, 0.25)
    assert held.clause.startswith("the friction force stands still for moments while the motion goes on")
    assert "up to 250 mN" in held.clause
    assert (
        held.note.startswith("In 3 of 6 runs the friction force stood still")
        and "7 times in all" in held.note
    )
