"""The first guess of the constants, read off records without simulating anything."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.opening import opening, scales
from fitting.signals import read_signals
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import NOISE, RATIOS, RIG, TRUTH, exact_run, noisy, own_run


def signals(*runs):
    return tuple(read_signals(run, NOISE) for run in runs)


@pytest.fixture(scope="module")
def exact():
    return signals(*(exact_run(ratio) for ratio in RATIOS))


def test_scales_are_the_sizes_of_force_speed_and_travel(exact):
    found = scales(exact)
    assert found.force == pytest.approx(TRUTH["A"] + TRUTH["C"], rel=0.1)
    assert found.displacement == pytest.approx(max(np.ptp(s.run.displacement) for s in exact) / 2)
    speed = max(np.max(np.abs(np.gradient(s.run.displacement, s.run.interval))) for s in exact)
    assert found.speed == pytest.approx(speed, rel=0.1)


def test_exact_records_give_C_and_k1_nearly(exact):
    found = opening(exact, scales(exact))
    assert found["C"] == pytest.approx(TRUTH["C"], rel=0.05)
    assert found["k1"] == pytest.approx(TRUTH["k1"], rel=0.3)
    assert set(found) == set(TRUTH)
    assert all(value >= 0 for value in found.values())


def test_on_a_guide_that_the_base_carries_the_mass_slides_over_the_base():
    rig = dataclasses.replace(RIG, friction_against="base")
    drives = [SineDrive(f, 10.325e-3) for f in (3.0, 3.2, 3.4)]
    seen = signals(*(own_run(drive, rig=rig, samples=1500, settling=3.0) for drive in drives))
    size = scales(seen)
    assert opening(seen, size)["C"] == pytest.approx(TRUTH["C"], rel=0.02)
    speed = max(np.max(np.abs(np.gradient(s.run.displacement - s.base, s.run.interval))) for s in seen)
    assert size.speed == pytest.approx(speed, rel=0.02)


def test_noise_leaves_C_and_the_order_of_k1():
    random = np.random.default_rng(11)
    seen = signals(*(noisy(exact_run(ratio), random) for ratio in RATIOS))
    found = opening(seen, scales(seen))
    assert found["C"] == pytest.approx(TRUTH["C"], rel=0.05)
    assert 1 / 3 < found["k1"] / TRUTH["k1"] < 3


def test_without_the_friction_channel_C_is_read_off_the_balance_of_forces():
    seen = signals(*(dataclasses.replace(exact_run(ratio), friction=None) for ratio in RATIOS))
    found = opening(seen, scales(seen))
    assert found["C"] == pytest.approx(TRUTH["C"], rel=0.2)
