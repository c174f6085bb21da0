"""Measuring chains against what they do in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.blind.filters import all_pass, lag, late, moving_average, play, resonance

STEP = 1.5e-4
TIMES = st.floats(0.2 * STEP, 40 * STEP)
TIME = STEP * np.arange(900)
SETTLED = 600


def ramp(slope: float = 3.0) -> np.ndarray:
    return 2.0 + slope * TIME


@pytest.mark.parametrize("filtered", [lag, late, moving_average, all_pass])
@given(TIMES)
def test_slow_changes_come_late_by_the_time_that_is_stated(filtered, time):
    expected = ramp() - 3.0 * time
    assert filtered(ramp(), STEP, time)[SETTLED:] == pytest.approx(expected[SETTLED:], rel=1e-6)


def test_two_poles_delay_by_their_damping():
    frequency, damping = 400.0, 0.6
    expected = ramp() - 3.0 * 2 * damping / (2 * np.pi * frequency)
    assert resonance(ramp(), STEP, frequency, damping)[SETTLED:] == pytest.approx(expected[SETTLED:])


@given(TIMES)
def test_a_moving_average_takes_from_a_wave_what_its_window_does(time):
    """sin(w time)/(w time) of it is left, `time` late; the samples are nearly linear in between."""
    w = 2 * np.pi * 20.0
    found = moving_average(np.sin(w * TIME), STEP, time)
    expected = np.sinc(w * time / np.pi) * np.sin(w * (TIME - time))
    assert np.abs(found - expected)[SETTLED:].max() < (w * STEP) ** 2 / 8


@pytest.mark.parametrize("filtered", [lag, late, moving_average, all_pass])
def test_what_stays_the_same_passes(filtered):
    assert filtered(np.full(50, 7.0), STEP, 3 * STEP) == pytest.approx(np.full(50, 7.0))


def test_a_play_follows_at_its_half_width():
    samples = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, -1, 99)[1:]])
    found = play(samples, 0.25)
    assert found[49] == pytest.approx(0.75) and found[-1] == pytest.approx(-0.75)
    assert found[60] == pytest.approx(0.75)
