"""The sine that drives a run, found or stated."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from jaxstick.cycle import Cycle, cycle_of, outcome_of
from jaxstick.record import KnownRig, Run

TIME = np.linspace(0.0, 5.0, 1000, endpoint=False)
SINE = 0.01 * np.sin(2 * np.pi * 1.3 * TIME + 0.4)
RIG = KnownRig(2.0, 2000.0, 2000.0, 1.0, 0.0)


def run(**given) -> Run:
    return Run(file="run-01.csv", time=TIME, displacement=SINE, rig=RIG, **given)


@pytest.mark.parametrize("channel", ["base", "force"])
def test_a_recorded_sine_is_found(channel):
    cycle = cycle_of(run(**{channel: SINE}))
    assert cycle is not None
    amplitudes = {"base": (0.01, 0.0), "force": (0.0, 0.01)}[channel]
    assert (cycle.frequency, cycle.phase) == pytest.approx((1.3, 0.4), rel=1e-6)
    assert (cycle.base_amplitude, cycle.force_amplitude) == pytest.approx(amplitudes, rel=1e-6)


def test_what_is_recorded_goes_before_what_is_stated():
    stated = {"frequency": 2.0, "base_amplitude": 0.02, "base_phase": 0.1}
    assert cycle_of(run(**stated)) == Cycle(2.0, 0.02, 0.0, 0.1)
    found = cycle_of(run(**stated, base=SINE))
    assert found is not None and found.frequency == pytest.approx(1.3, rel=1e-6)


@pytest.mark.parametrize(
    "given",
    [
        {"base": np.sign(SINE)},
        {"base": np.sin(2 * np.pi * 0.1 * TIME)},
        {"base": np.zeros_like(TIME)},
        {"base": SINE, "force": SINE},
        {"frequency": 1.3},
        {},
    ],
    ids=["square", "less than a cycle", "at rest", "two drives", "no amplitude", "nothing"],
)
def test_what_is_not_one_sine_has_no_cycle(given):
    assert cycle_of(run(**given)) is None
    assert outcome_of(run(**given)) is None


def test_the_outcome_is_that_of_the_last_cycles():
    recorded = run(base=SINE)
    whole = outcome_of(recorded)
    assert whole is not None and (whole.cycles, whole.stops) == (6, 0)
    settling = dataclasses.replace(recorded, displacement=np.where(TIME < 2.5, 3 * SINE, SINE))
    all_of_it, last = outcome_of(settling), outcome_of(settling, 1)
    assert all_of_it is not None and all_of_it.amplitude == pytest.approx(0.03, rel=1e-3)
    assert last is not None and last.amplitude == pytest.approx(0.01, rel=1e-3)


def test_less_than_a_cycle_has_no_outcome():
    assert outcome_of(run(frequency=0.1, base_amplitude=0.01)) is None
