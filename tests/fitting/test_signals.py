"""What is read off a record before anything is fitted."""

from __future__ import annotations

import dataclasses

import numpy as np

from fitting.signals import read_signals
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import NOISE, noisy, own_run


def test_the_sense_of_the_last_sliding_is_kept_while_the_mass_rests():
    """Until the load comes near the limit the other way, where the contact rings and may yield."""
    exact = own_run(SineDrive(0.8, 10.325e-3), samples=900)
    seen = read_signals(noisy(exact, np.random.default_rng(7)), NOISE)
    velocity = np.gradient(exact.displacement, exact.interval)
    slides = np.abs(velocity) > 0.1 * np.max(np.abs(velocity))
    assert np.array_equal(seen.slid[slides], np.sign(velocity[slides]))
    last = np.maximum.accumulate(np.where(slides, np.arange(len(slides)), 0))
    since = np.arange(len(slides)) - last
    resting = (last > 0) & (since > 2) & (since < 60)
    assert np.count_nonzero(resting) > 100
    assert np.mean(seen.slid[resting] == np.sign(velocity[last][resting])) > 0.98
    assert set(np.unique(seen.slid)) <= {-1.0, 0.0, 1.0}


def test_a_mass_that_has_not_moved_yet_has_not_slid():
    """Before the base starts nothing is known of what the contact went through."""
    exact = own_run(SineDrive(0.8, 10.325e-3), samples=900)
    first = int(np.flatnonzero(np.abs(exact.displacement) > 1e-4)[0])
    seen = read_signals(exact, NOISE)
    assert np.all(seen.slid[: first // 4] == 0)


def test_the_recorded_force_is_smoothed():
    exact = own_run(SineDrive(0.8, 10.325e-3), samples=900)
    run = noisy(exact, np.random.default_rng(7))
    seen, slides = read_signals(run, NOISE), np.abs(np.gradient(exact.displacement)) > 2e-5

    def error(force: np.ndarray) -> float:
        return float(np.sqrt(np.mean((force - exact.friction)[slides] ** 2)))

    assert run.friction is not None and error(seen.recorded) < 0.8 * error(run.friction)
    unrecorded = read_signals(dataclasses.replace(run, friction=None), NOISE)
    assert np.all(np.isnan(unrecorded.recorded))
