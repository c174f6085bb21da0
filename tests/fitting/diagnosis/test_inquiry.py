"""What is seen only in runs that took no part."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.diagnose import diagnose
from fitting.diagnosis.inquiry import Inquiry
from fitting.diagnosis.settings import DiagnosisSettings
from jaxstick.effect import AbstractEffect
from jaxstick.effects.mains_hum import MainsHum
from jaxstick.parts.drive import SineDrive
from jaxstick.record import DataSet
from tests.fitting.diagnosis.test_shrink import CLOSED
from tests.fitting.reference_data import WRONG, dataset, noisy, own_run

HUMS = "run-2.csv"
"""The one of four runs that is held out where nobody names any."""


def records() -> DataSet:
    """Four noisy runs, the force of one of which hums by three times its noise."""
    random = np.random.default_rng(4)
    runs = []
    for n, frequency in enumerate((0.8, 1.5, 2.6, 3.8)):
        file = f"run-{n}.csv"
        effects: dict[str, AbstractEffect] = {}
        if file == HUMS:
            effects["hum"] = MainsHum(cosine=0.08, sine=0.05, frequency=50.0)
        drive = SineDrive(frequency, 10.325e-3)
        runs.append(noisy(own_run(drive, effects=effects, samples=700, file=file), random))
    return dataset(*runs, assumed=WRONG)


def test_what_only_a_run_shows_that_was_held_out_is_named_with_another_held_out():
    found = diagnose(records(), DiagnosisSettings(workers=2))
    assert (found.verdict, found.named) == ("effect", ("mains_hum",))
    assert found.closure.held_out and HUMS not in found.closure.held_out


def test_a_gap_in_runs_that_are_to_be_held_out_is_said_to_be_there():
    """They stay so, nothing is named, and it is not called none."""
    found = diagnose(records(), DiagnosisSettings(hold_out=(HUMS,), workers=2))
    assert (found.verdict, found.named, found.closure.held_out) == ("unlisted", (), (HUMS,))
    assert found.closure.before > 1.5
    assert "something acts there that the others do not show" in found.notes[0] and HUMS in found.notes[0]


@pytest.mark.parametrize(
    ("verdict", "before", "scatters", "gapes"),
    [
        ("none", 1.2, False, True),
        ("none", 1.05, False, False),
        ("none", 1.2, True, False),
        ("effect", 1.2, False, False),
    ],
)
def test_a_gap_only_there_is_none_where_something_was_found_or_friction_scatters(
    verdict, before, scatters, gapes
):
    blank: Any = None
    found: Any = SimpleNamespace(judgement=SimpleNamespace(verdict=verdict))
    bench: Any = SimpleNamespace(scatters=scatters)
    shrunk = dataclasses.replace(CLOSED, before=before, floor=1.0)
    assert Inquiry(blank, bench, blank, found, None, shrunk, False).gapes_only_there is gapes
