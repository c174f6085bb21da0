"""A force that oscillates by itself is told from noise, from scatter and from what the drive does."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.lanes.jobs import predicted
from fitting.diagnosis.unlisted.own_beat import OwnBeat, own_beat
from fitting.problem import pose
from fitting.settings import Settings
from jaxstick.effect import AbstractEffect
from jaxstick.effects.cubic_stiffness import CubicStiffness
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Run
from tests.fitting.diagnosis.geared import GEAR, Gear
from tests.fitting.diagnosis.grounded import WORKERS, from_the_truth, laid_out
from tests.fitting.reference_data import NOISE, TRUTH, dataset, noisy, own_run

FREQUENCIES = (0.9, 1.5, 2.1, 2.6)
SMALL = 0.03
"""A force [N] that is a hundredth of the friction force."""


def found_in(
    effects: dict[str, AbstractEffect], runs: int = 4, geared: int = 4, scatter: float = 0.0
) -> OwnBeat | None:
    """What is found in so many runs of the 1987 rig, on the first of which these effects act. The friction
    force is recorded with so many times its noise, which the mass does not feel."""
    assert NOISE.friction is not None
    random, made = np.random.default_rng(3), []
    for number, frequency in enumerate(FREQUENCIES[:runs]):
        acting = effects if number < geared else {}
        run: Run = own_run(
            SineDrive(frequency, 10.325e-3), effects=acting, samples=1500, file=f"{number}.csv"
        )
        run = noisy(run, random)
        assert run.friction is not None
        more = scatter * NOISE.friction * random.standard_normal(len(run.friction))
        made.append(dataclasses.replace(run, friction=run.friction + more))
    stated = dataset(*made)
    model, bench = laid_out(stated)
    point = from_the_truth(model, bench, (), model.origin(TRUTH)).point
    seen = predicted(model, bench, point)
    return own_beat(pose(stated, Settings(workers=WORKERS)), model, bench, point, seen)


def test_a_small_force_that_oscillates_is_found_with_its_frequency():
    found = found_in({"gear": Gear(SMALL)})
    assert found is not None and found.runs >= 2 and found.of == 4
    assert found.frequency == pytest.approx(GEAR, abs=0.05)


@pytest.mark.parametrize(
    ("effects", "named"),
    [
        pytest.param({}, {}, id="noise alone"),
        pytest.param({}, {"scatter": 20.0}, id="a force that scatters"),
        pytest.param({"cubic_stiffness": CubicStiffness(4e5)}, {}, id="harmonics of the drive"),
        pytest.param({"gear": Gear(SMALL)}, {"geared": 1}, id="in one of four runs"),
        pytest.param({"gear": Gear(SMALL)}, {"runs": 1}, id="one run alone"),
    ],
)
def test_what_else_there_is_has_no_beat(effects, named):
    assert found_in(effects, **named) is None


def test_a_beat_is_said_with_its_frequency_and_how_often():
    beat = OwnBeat(16.61, 5, 6, True)
    assert beat.clause.startswith("a force on the mass oscillates at 16.61 Hz")
    assert beat.note.startswith("In 5 of 6 runs a force on the mass oscillates at 16.61 Hz")
