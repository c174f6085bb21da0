"""Where the mass has been before a segment, also before its run began."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.history import CYCLES, History
from fitting.signals import read_signals
from jaxstick.record import Noise, Run
from tests.fitting.reference_data import RIG

INTERVAL, FREQUENCY = 2e-3, 1.3
NOISE = Noise(displacement=1e-6)
PERIOD = 0.4


def moved(x: np.ndarray, frequency: float | None = FREQUENCY) -> History:
    """The history of a run with this displacement, whose base is not recorded."""
    time = 0.3 + INTERVAL * np.arange(len(x), dtype=float)
    amplitude = None if frequency is None else 0.01
    run = Run(file="a.csv", time=time, displacement=x, frequency=frequency, base_amplitude=amplitude, rig=RIG)
    return History.of(read_signals(run, NOISE), PERIOD)


def swing(time: np.ndarray) -> np.ndarray:
    """The base's displacement as it is stated."""
    return 0.01 * np.sin(2 * np.pi * FREQUENCY * time)


def wave(time: np.ndarray) -> np.ndarray:
    return 0.01 * np.sin(2 * np.pi * FREQUENCY * time + 0.4) + 0.004 * np.sin(6 * np.pi * FREQUENCY * time)


@pytest.mark.parametrize("cycles", [1.05, 1.8, 4.3])
def test_a_motion_that_repeats_itself_did_so_before_its_record(cycles: float):
    time = INTERVAL * np.arange(round(cycles / FREQUENCY / INTERVAL), dtype=float)
    for sample in (0, 30, len(time) - 1):
        lags, x, base = moved(wave(time)).track(sample)
        assert lags[0] == 0 and np.all(np.diff(lags) > 0)
        assert lags[-1] == pytest.approx(CYCLES / FREQUENCY)
        assert x == pytest.approx(wave(time[sample] - lags), abs=3e-5)
        assert base == pytest.approx(swing(0.3 + time[sample] - lags), abs=3e-5)


@pytest.mark.parametrize(
    ("cycles", "frequency"), [(4.3, FREQUENCY), (0.7, FREQUENCY), (4.3, None)], ids=["grows", "short", "free"]
)
def test_a_motion_that_does_not_repeat_itself_began_at_rest(cycles: float, frequency: float | None):
    """One that has just begun, one of which too little is seen, and one whose excitation has no cycle."""
    time = INTERVAL * np.arange(round(cycles / FREQUENCY / INTERVAL), dtype=float)
    x = 0.002 + wave(time) * (time if cycles > 1 else 1.0)
    history = moved(x, frequency)
    lags, before, _ = history.track(50)
    known = lags <= time[50]
    assert before[known] == pytest.approx(np.interp(time[50] - lags[known], time, x), abs=1e-12)
    assert np.all(before[~known] == x[0]) and np.any(~known)
    assert lags[-1] == pytest.approx(CYCLES * (PERIOD if frequency is None else 1 / FREQUENCY))


@pytest.mark.parametrize("repeats", [True, False])
def test_a_record_that_begins_at_rest_came_to_rest_as_it_does_later(repeats: bool):
    """Of a motion that has no cycle nobody knows."""
    time = INTERVAL * np.arange(1500, dtype=float)
    turning = 2 * np.pi * FREQUENCY * time - 0.3
    flat = np.arcsin(np.clip(1.6 * np.sin(turning + np.pi / 2), -1, 1))
    history = moved(0.01 * flat, FREQUENCY if repeats else None)
    cycle = round(1 / FREQUENCY / INTERVAL)
    first, later = history.before(20), history.before(20 + cycle)
    assert history.signal.slid[20] == 0 and later.slid == 1 and 0.05 < later.rest < 0.3
    assert first.slid == (later.slid if repeats else 0)
    assert first.rest == pytest.approx(later.rest if repeats else 20 * INTERVAL, abs=INTERVAL)
    moving = history.before(300)
    assert (moving.rest, moving.slid) == (history.signal.rest[300], history.signal.slid[300])


def test_the_force_channel_is_looked_back_upon_sample_by_sample_at_first():
    time = INTERVAL * np.arange(1500, dtype=float)
    run = moved(wave(time)).signal.run
    shown = dataclasses.replace(run, friction=100 * wave(time))
    history = History.of(read_signals(shown, dataclasses.replace(NOISE, friction=1e-3)), PERIOD)
    for sample in (3, 700):
        lags, force = history.shown(sample)
        assert lags[0] == 0 and lags[1] == pytest.approx(INTERVAL) and np.all(np.diff(lags) > 0)
        assert force == pytest.approx(100 * wave(time[sample] - lags), abs=5e-3)
    assert np.all(moved(wave(time)).shown(3)[1] == 0.0)
