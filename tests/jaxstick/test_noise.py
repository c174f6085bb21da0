"""The noise found without a model, against noise that was put in."""

import numpy as np
import pytest

from jaxstick.noise import analyse_noise, estimate_noise, noise_levels, noise_summary
from jaxstick.record import DataSet, KnownRig, Noise, Run

RIG = KnownRig(2.38, 1986.0, 1986.0, 4.53, 0.0)
PER_CYCLE = 256


def stick_slip(cycles: int = 12, per_cycle: int = PER_CYCLE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], displacement [m] and friction [N] of the 1987 rig at 0.92 Hz with a damped contact spring.

    Semi-implicit steps of 40 us; F = -(k1 z + 30 N s/m v) in stick, clipped to the limit.
    """
    frequency, step, contact = 0.92, 1 / (0.92 * per_cycle * (4096 * 6 // per_cycle)), 99300.0
    between = 4096 * 6 // per_cycle
    x = v = z = 0.0
    displacement, friction = np.zeros((2, cycles * per_cycle))
    base = 0.010325 * np.sin(2 * np.pi * frequency * step * np.arange(cycles * per_cycle * between))
    for i, y in enumerate(base.tolist()):
        limit = 1.49 * np.exp(-100 * abs(v)) + 5.98
        trial = contact * (z + step * v)
        if abs(trial) > limit:
            force = limit if trial > 0 else -limit
            z = force / contact
        else:
            z += step * v
            force = trial + 30 * v
        v += step * (1986 * (y - x) - 4.53 * v - force) / 2.38
        x += step * v
        if i % between == between - 1:
            displacement[i // between], friction[i // between] = x, -force
    return step * between * np.arange(1, cycles * per_cycle + 1), displacement, friction


@pytest.fixture(scope="module")
def motion() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return stick_slip()


def bias(signal: np.ndarray, sd: float) -> float:
    """Mean of found over true standard deviation, over six draws of noise."""
    rng = np.random.default_rng(7)
    return float(np.mean([estimate_noise(signal + rng.normal(0, sd, len(signal))) for _ in range(6)])) / sd


@pytest.mark.parametrize(("sd", "high"), [(0.8e-6, 1.12), (8e-6, 1.06), (80e-6, 1.03)])
def test_noise_of_a_displacement(motion, sd, high):
    assert 0.97 < bias(motion[1], sd) < high


@pytest.mark.parametrize(("sd", "low", "high"), [(0.005, 1.0, 1.3), (0.05, 0.97, 1.25), (0.5, 0.97, 1.12)])
def test_noise_of_a_friction_force(motion, sd, low, high):
    assert low < bias(motion[2], sd) < high


def test_motion_counts_as_noise_where_it_is_sampled_too_coarsely():
    _, displacement, _ = stick_slip(per_cycle=48)
    assert bias(displacement, 8e-6) > 1.3


def test_a_fast_smooth_motion_is_no_noise():
    """Twelve samples a cycle: no polynomial follows that over a window; differences of order 10 see none."""
    rng = np.random.default_rng(16)
    sine = np.sin(np.arange(1500) * 2 * np.pi / 12)
    found = [estimate_noise(sine + rng.normal(0, 1e-3, 1500)) / 1e-3 for _ in range(12)]
    assert np.mean(found) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("samples", [64, 256, 2000])
def test_pure_noise_is_found_without_bias(samples):
    rng = np.random.default_rng(0)
    found = [estimate_noise(rng.normal(size=samples)) for _ in range(200)]
    assert np.mean(found) == pytest.approx(1.0, abs=0.04)
    assert np.std(found) < 1.8 / np.sqrt(samples)


@pytest.mark.parametrize("quantum", [0.8e-6, 8e-6, 24e-6, 80e-6])
def test_a_digitiser_adds_its_own_noise(motion, quantum):
    """Above a quantum of three standard deviations the steps count as noise of quantum / sqrt(12) at
    least, and as up to a quarter more."""
    rng = np.random.default_rng(5)
    noisy = motion[1] + rng.normal(0, 8e-6, len(motion[1]))
    found = analyse_noise(np.round(noisy / quantum) * quantum)
    assert found.quantum == pytest.approx(quantum, rel=1e-6)
    assert 0.97 < found.sd / np.hypot(8e-6, quantum / np.sqrt(12)) < (1.08 if quantum < 30e-6 else 1.25)


@pytest.mark.parametrize(("quantum", "digits"), [(5.976e-6, 7), (1.2518e-6, 8), (33.1e-6, 6), (1e-6, 6)])
def test_steps_that_were_written_with_fewer_digits_are_found(motion, quantum, digits):
    """They differ by up to a fiftieth then; what has no steps has none."""
    noisy = motion[1] + np.random.default_rng(6).normal(0, 1e-6, len(motion[1]))
    found = analyse_noise(np.round(np.round(noisy / quantum) * quantum, digits))
    assert found.quantum == pytest.approx(quantum, rel=0.01)
    assert found.sd > 0.95 * quantum / np.sqrt(12)
    assert analyse_noise(noisy).quantum == 0.0


def test_a_record_frozen_between_two_steps(motion):
    steps = np.round(motion[1] / 1e-3) * 1e-3
    assert estimate_noise(steps) == pytest.approx(1e-3 / np.sqrt(12), rel=1e-3)


def test_a_channel_that_never_changes_has_no_noise():
    found = analyse_noise(np.full(600, 3.0))
    assert (found.sd, found.quantum, found.lag1, found.coloured) == (0.0, 0.0, None, False)


def lag1(signal: np.ndarray) -> float:
    found = analyse_noise(signal).lag1
    assert found is not None
    return found


def autoregressive(count: int, correlation: float, rng: np.random.Generator) -> np.ndarray:
    noise = rng.normal(size=count)
    for i in range(1, count):
        noise[i] = correlation * noise[i - 1] + np.sqrt(1 - correlation**2) * noise[i]
    return noise


def test_coloured_noise_is_flagged(motion):
    rng = np.random.default_rng(11)
    count = len(motion[1])
    correlations = (-0.6, 0.0, 0.6, 0.9)
    found = [analyse_noise(motion[1] + 8e-6 * autoregressive(count, each, rng)) for each in correlations]
    assert [estimate.coloured for estimate in found] == [True, False, True, True]


def test_the_correlation_of_neighbours_is_told():
    rng = np.random.default_rng(12)
    lags = [lag1(8e-6 * autoregressive(20_000, each, rng)) for each in (-0.6, -0.3, 0.0, 0.3, 0.6, 0.9)]
    assert lags == sorted(lags)
    assert lags[:4] == pytest.approx([-0.6, -0.3, 0.0, 0.3], abs=0.1)
    assert min(lags[4:]) > 0.45


def test_white_noise_is_not_flagged(motion):
    rng = np.random.default_rng(13)
    for signal, sd in ((motion[1], 8e-6), (motion[2], 0.05), (0 * motion[0], 1.0)):
        lags = [lag1(signal + rng.normal(0, sd, len(signal))) for _ in range(12)]
        assert np.abs(lags).max() < 0.5
        assert abs(np.mean(lags)) < 0.2


@pytest.mark.parametrize(("correlation", "low"), [(0.1, 0.96), (0.4, 0.74)])
def test_noise_of_neighbours_that_correlate_is_found_better_in_windows(motion, correlation, low):
    """Differences of higher order show the fastest part of it alone: 0.94 and 0.68 of it."""
    rng = np.random.default_rng(14)
    count = len(motion[1])
    found = [estimate_noise(motion[1] + 8e-6 * autoregressive(count, correlation, rng)) for _ in range(12)]
    assert low < np.mean(found) / 8e-6 < 1.05


@pytest.mark.parametrize(("corners", "high"), [(0, 1.03), (20, 1.05), (80, 1.15)])
def test_corners_hardly_count_as_noise(corners, high):
    """In 3000 samples: of eighty every other window has one."""
    rng = np.random.default_rng(15)
    zigzag = np.interp(np.arange(3000), np.linspace(0, 3000, corners + 2), np.arange(corners + 2) % 2)
    found = [estimate_noise(zigzag + rng.normal(0, 1e-4, 3000)) / 1e-4 for _ in range(12)]
    assert 0.97 < np.mean(found) < high


def test_a_short_record_does_not_tell_the_colour():
    assert analyse_noise(np.random.default_rng(0).normal(size=100)).lag1 is None


def data_set(noise: Noise, sds: tuple[float, ...]) -> DataSet:
    rng = np.random.default_rng(17)
    time = np.arange(800) / 200
    runs = tuple(
        Run(
            file=f"run-{number}.csv",
            time=time,
            displacement=np.sin(time) + rng.normal(0, sd, 800),
            base=np.sin(2 * time),
            rig=RIG,
        )
        for number, sd in enumerate(sds)
    )
    return DataSet(name="a", rig=RIG, noise=noise, runs=runs)


def test_levels_are_as_stated_or_the_runs_median():
    found = noise_levels(data_set(Noise(), (1e-3, 2e-3, 9e-3)))
    assert found.displacement == pytest.approx(2e-3, rel=0.15)
    assert found.base == pytest.approx(1e-6, rel=1e-3)
    assert found.friction is None
    stated = noise_levels(data_set(Noise(displacement=5e-3, force=1.0), (1e-3,)))
    assert (stated.displacement, stated.force) == (5e-3, 1.0)


def test_the_summary_has_every_channel_of_every_run():
    summary = noise_summary(data_set(Noise(displacement=5e-3), (1e-3, 2e-3)))
    assert [(entry.file, entry.channel, entry.stated) for entry in summary] == [
        ("run-0.csv", "displacement", 5e-3),
        ("run-0.csv", "base", None),
        ("run-1.csv", "displacement", 5e-3),
        ("run-1.csv", "base", None),
    ]
    assert summary[2].found.sd == pytest.approx(2e-3, rel=0.15)
