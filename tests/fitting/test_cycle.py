"""How long a cycle of a run's excitation is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.cycle import samples_a_cycle, whole_cycles
from jaxstick.record import KnownRig, Run

RIG = KnownRig(2.38, 1986.0, 1986.0, 4.53, 0.0)
SAMPLES = 1200


def driven(base: np.ndarray, frequency: float | None = None) -> Run:
    """A run whose base moves so, every 5 ms."""
    return Run(
        file="run-01.csv",
        rig=RIG,
        time=np.linspace(0, 0.005 * (len(base) - 1), len(base)),
        displacement=base,
        base=base,
        frequency=frequency,
    )


def sine(cycles: float, phase: float = 0.0) -> np.ndarray:
    return 3e-3 + 1e-2 * np.sin(2 * np.pi * cycles * np.arange(SAMPLES) / SAMPLES + phase)


@given(st.floats(1.05, 30.0), st.floats(-3.0, 3.0))
def test_a_sine_has_a_cycle_wherever_its_record_ends(cycles, phase):
    """What a record that holds no whole cycles has of a sine's variance is not half its amplitude squared."""
    run = driven(sine(cycles, phase))
    assert samples_a_cycle(run) == pytest.approx(SAMPLES / cycles, rel=1e-3)
    whole = math.floor(cycles * (1 + 0.5 / SAMPLES))
    assert whole_cycles(run) == pytest.approx(whole * SAMPLES / cycles, abs=0.6)


@pytest.mark.parametrize(("noise", "found"), [(0.5e-3, True), (2e-3, False)])
def test_a_cycle_is_seen_through_a_little_noise(noise, found):
    run = driven(sine(4.3) + noise * np.random.default_rng(2).standard_normal(SAMPLES))
    assert (samples_a_cycle(run) is not None) is found


def test_most_of_a_cycle_shows_how_long_it_is():
    assert samples_a_cycle(driven(sine(0.9))) == pytest.approx(SAMPLES / 0.9, rel=1e-3)
    assert whole_cycles(driven(sine(0.9))) == SAMPLES


def test_a_base_that_does_not_come_back_has_none():
    assert samples_a_cycle(driven(sine(0.6))) is None
    assert samples_a_cycle(driven(1e-3 * np.arange(SAMPLES, dtype=float))) is None


def test_what_is_stated_counts():
    assert samples_a_cycle(driven(sine(4.3), frequency=2.0)) == pytest.approx(100.0)
