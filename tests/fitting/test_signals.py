"""What is read off a record before anything is fitted."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.signals import AHEAD, base_motion, read_signals
from jaxstick.noise import estimate_noise
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import NOISE, RIG, noisy, own_run

CARRIED = SineDrive(3.0, 10.325e-3)


def test_the_sense_of_the_last_sliding_is_kept_while_the_mass_rests():
    """Until the load comes near the limit the other way, where the contact rings and may yield."""
    exact = own_run(SineDrive(0.8, 10.325e-3), samples=900)
    seen = read_signals(noisy(exact, np.random.default_rng(7)), NOISE)
    velocity = np.gradient(exact.displacement, exact.interval)
    slides = np.abs(velocity) > 0.15 * np.max(np.abs(velocity))
    assert np.array_equal(seen.slid[slides], np.sign(velocity[slides]))
    last = np.maximum.accumulate(np.where(slides, np.arange(len(slides)), 0))
    since = np.arange(len(slides)) - last
    resting = (last > 0) & (since > 2) & (since < 60)
    assert np.count_nonzero(resting) > 100
    assert np.mean(seen.slid[resting] == np.sign(velocity[last][resting])) > 0.98
    assert set(np.unique(seen.slid)) <= {-1.0, 0.0, 1.0}


def test_a_contact_holds_since_the_mass_slid_last_though_it_rings():
    """The time of rest runs on while it moves to and fro by what its spring gives way to, from where its
    velocity passed through zero first."""
    exact = own_run(SineDrive(0.8, 10.325e-3), samples=900)
    seen = read_signals(noisy(exact, np.random.default_rng(7)), NOISE)
    velocity = np.gradient(exact.displacement, exact.interval)
    speed = np.abs(velocity)
    slides = speed > 0.1 * np.max(speed)
    last = np.maximum.accumulate(np.where(slides, np.arange(len(slides)), 0))
    turns = np.flatnonzero(velocity[1:] * velocity[:-1] <= 0)
    turns = np.append(turns, len(velocity))
    arrest = np.where(last > 0, turns[np.searchsorted(turns, last)] + 0.5, 0.0)
    held = (np.arange(len(slides)) - arrest) * exact.interval
    stuck = (last > 0) & (held > 0.05) & (held < 0.2)
    assert np.count_nonzero(stuck) > 50 and np.max(speed[stuck]) > 0.08 * np.max(speed)
    assert np.median(np.abs(seen.rest[stuck] - held[stuck])) < 0.5 * exact.interval
    assert np.mean(seen.rest <= np.maximum(held, 0) + 0.02) > 0.98
    assert np.all(seen.rest[speed > 0.3 * np.max(speed)] == 0)


def test_a_mass_rests_on_a_base_that_carries_it_along():
    """It slides where it moves against the guide, not where it moves."""
    rig = dataclasses.replace(RIG, friction_against="base")
    exact = own_run(CARRIED, rig=rig, samples=1500, settling=3.0)
    assert exact.base is not None
    seen = read_signals(noisy(exact, np.random.default_rng(7)), NOISE)
    slide = exact.displacement - exact.base
    rate = np.gradient(slide, exact.interval)
    assert np.sqrt(np.mean((seen.slide_rate - rate) ** 2)) < 0.05 * np.std(rate)
    assert np.sqrt(np.mean((seen.slide - slide) ** 2)) < 2 * seen.displacement_noise
    slides, rests = (np.abs(rate) > 0.3 * np.max(np.abs(rate))), np.abs(rate) < 0.05 * np.max(np.abs(rate))
    assert np.count_nonzero(rests) > 20 and np.min(np.abs(seen.velocity[rests])) > np.max(np.abs(rate))
    assert np.array_equal(seen.slid[slides], np.sign(rate[slides]))
    arrested = np.flatnonzero(rate[1:] * rate[:-1] <= 0) + 1
    assert len(arrested) > 15 and np.all(seen.rest[slides] == 0)
    since = seen.rest[arrested + 1] / exact.interval
    assert np.all((since > 0.5) & (since < 2.5))


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


TIME = np.arange(1200) * 4e-3
BASE_NOISE = 5e-6
EDGES = 0.01 * np.sign(np.sin(2 * np.pi * 0.7 * TIME))
MOTIONS = {
    "a sine seen for one cycle": 0.016 * np.sin(2 * np.pi * 0.21 * TIME + 0.4),
    "two tones in tune": 0.01 * np.sin(2 * np.pi * 1.1 * TIME) + 0.002 * np.sin(2 * np.pi * 3.3 * TIME + 1),
    "a sweep": 0.01 * np.sin(2 * np.pi * (0.3 + 0.2 * TIME) * TIME),
}


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_noise_of_a_recorded_base_does_not_shake_the_contact(motion: str):
    """Half of it at most is left, and less of what lies beyond 15 Hz."""
    noise = BASE_NOISE * np.random.default_rng(2).standard_normal(len(TIME))
    run = dataclasses.replace(
        own_run(SineDrive(0.8, 1e-2), samples=1200), base=MOTIONS[motion] + noise, time=TIME
    )
    off = base_motion(run, TIME)[0] - MOTIONS[motion]
    assert np.std(off) < BASE_NOISE / 2
    fast = np.fft.rfftfreq(len(TIME), 4e-3) > 15
    spectra = [np.abs(np.fft.rfft(part * np.hanning(len(TIME))))[fast] for part in (off, noise)]
    assert np.linalg.norm(spectra[0]) < np.linalg.norm(spectra[1]) / 20


def test_a_base_is_smoothed_however_its_noise_is_misjudged():
    """A short record tells it to a thirteenth; what is left of a sine that fits is as white as noise is."""
    sine = MOTIONS["a sine seen for one cycle"]
    plain = own_run(SineDrive(0.8, 1e-2), samples=1200)
    misjudged = 0
    for seed in range(60):
        base = sine + BASE_NOISE * np.random.default_rng(seed).standard_normal(len(TIME))
        misjudged += estimate_noise(base) < BASE_NOISE / 1.06
        smooth = base_motion(dataclasses.replace(plain, base=base, time=TIME), TIME)[0]
        assert np.std(smooth - sine) < BASE_NOISE / 5, seed
    assert misjudged > 0


def test_a_base_with_edges_is_left_as_it_was_recorded():
    noise = BASE_NOISE * np.random.default_rng(2).standard_normal(len(TIME))
    run = dataclasses.replace(own_run(SineDrive(0.8, 1e-2), samples=1200), base=EDGES + noise, time=TIME)
    base, ahead = base_motion(run, TIME)
    np.testing.assert_array_equal(base, EDGES + noise)
    assert len(ahead) == 0


@pytest.mark.parametrize("recorded", [True, False])
def test_a_sine_is_known_beyond_the_end_of_the_run(recorded: bool):
    run = own_run(SineDrive(0.8, 1e-2), samples=1200)
    time = run.time[-1] + run.interval * np.arange(1, AHEAD + 1)
    if recorded:
        run = dataclasses.replace(run, frequency=None, base=1e-2 * np.sin(2 * np.pi * 0.8 * run.time))
    else:
        run = dataclasses.replace(run, frequency=0.8, base_amplitude=1e-2, base_phase=0.0, base=None)
    ahead = read_signals(run, NOISE).ahead
    np.testing.assert_allclose(ahead, 1e-2 * np.sin(2 * np.pi * 0.8 * time), atol=1e-6)
