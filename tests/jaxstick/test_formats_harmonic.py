"""The sine of a recorded base."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxstick.formats.harmonic import fit_harmonic


@settings(max_examples=100, deadline=None)
@given(
    cycles=st.floats(1.6, 40.0),
    phase=st.floats(-3.0, 3.0),
    amplitude=st.floats(1e-6, 10.0),
    start=st.floats(-5.0, 5.0),
)
def test_a_sine_is_found_exactly(cycles, phase, amplitude, start):
    time = start + np.arange(500) / 100
    frequency = cycles / 5
    found = fit_harmonic(time, 0.3 * amplitude + amplitude * np.sin(2 * np.pi * frequency * time + phase))
    assert found.frequency == pytest.approx(frequency, rel=1e-6)
    assert found.amplitude == pytest.approx(amplitude, rel=1e-6)
    assert found.mean == pytest.approx(0.3 * amplitude, rel=1e-5)
    assert math.remainder(found.phase - phase, 2 * math.pi) == pytest.approx(0, abs=1e-4)


def test_noise_and_harmonics_hardly_matter():
    time = np.arange(4000) / 250
    rng = np.random.default_rng(3)
    base = (
        np.sin(2 * np.pi * 0.92 * time) + 0.05 * np.sin(2 * np.pi * 2.76 * time) + rng.normal(0, 0.02, 4000)
    )
    found = fit_harmonic(time, base)
    assert found.frequency == pytest.approx(0.92, abs=2e-4)
    assert found.amplitude == pytest.approx(1.0, abs=3e-3)


def test_a_given_frequency_is_kept():
    time = np.arange(300) / 100
    found = fit_harmonic(time, 2 * np.sin(2 * np.pi * time), frequency=1.0)
    assert (found.frequency, round(found.amplitude, 9)) == (1.0, 2.0)


def test_one_cycle_in_noise_is_enough():
    """Where amplitude, phase and mean can make good for much of a wrong frequency."""
    time = np.arange(0, 8.6, 4e-3)
    noise = 6e-6 * np.random.default_rng(1).standard_normal(len(time))
    found = fit_harmonic(time, 0.015 * np.sin(2 * np.pi * 0.1276 * time + 1.2) + noise)
    assert found.frequency == pytest.approx(0.1276, rel=2e-4)
