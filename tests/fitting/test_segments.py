"""Segments laid out as lanes."""

from __future__ import annotations

import math

import jax
import numpy as np
import pytest

from fitting.problem import pose
from fitting.segments import Segment, lay_out
from fitting.settings import Settings
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import RATE, dataset, own_run

SAMPLES = 200
STEP = 1 / RATE
SKIPPED = 0.5
"""When the sine began before the run [s]."""


def test_the_drive_goes_on_past_the_last_sample_of_a_record():
    """Lanes that are filled up beyond the end of their run see the base of the last sample at that sample,
    and beyond it a sine that goes on: a base that was read late asks for it."""
    sine = SineDrive(1.5, 10e-3)
    run = own_run(sine, samples=SAMPLES, file="run-0.csv")
    assert run.base is not None
    problem = pose(dataset(run), Settings())
    lanes = lay_out(
        problem.chosen, [Segment(0, SAMPLES - 30, SAMPLES)], problem.dataset.rig, 1.0, 2, beyond=20
    )
    drive = jax.tree.map(lambda leaf: leaf[0], lanes.drive)
    last = run.time[-1]
    step = run.interval
    with jax.enable_x64(True):
        before, at, after = (drive.at(last + share * step) for share in (-1e-6, 0.0, 0.5))
        later, goes_on = drive.at(last + 10.5 * step), sine.at(SKIPPED + last + 10.5 * step)
    assert float(at.y) == pytest.approx(run.base[-1], abs=1e-6)
    assert float(at.y) == pytest.approx(float(before.y), abs=1e-7)
    assert float(later.y) == pytest.approx(float(goes_on.y), abs=1e-6)
    assert float(after.y) == pytest.approx(float(at.y) + 0.5 * step * float(at.y_rate), abs=2e-5)


@pytest.mark.parametrize("cycles", [0.9, 1.45, 2.4])
def test_the_extent_of_a_sine_is_its_amplitude_wherever_the_record_breaks_off(cycles: float):
    """Effects that go by the drive's amplitude would else be by as much too strong or weak; of less than a
    cycle there is no telling."""
    sine = SineDrive(1.5, 10e-3)
    run = own_run(sine, samples=round(cycles / (1.5 * STEP)), file="run-0.csv")
    assert run.base is not None
    problem = pose(dataset(run), Settings())
    count = len(run.time)
    lanes = lay_out(problem.chosen, [Segment(0, 0, count)], problem.dataset.rig, 1.0, 2)
    assert lanes.drive.whole is not None
    found = [float(np.asarray(part)[0]) for part in lanes.drive.whole]
    if cycles > 1:
        assert found[:2] == pytest.approx([10e-3, 2 * math.pi * 1.5 * 10e-3], rel=5e-3)
    else:
        assert found[0] == pytest.approx(math.sqrt(2) * float(np.std(run.base)), rel=1e-2)
