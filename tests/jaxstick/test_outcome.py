"""Amplitude and stops: of the rig of 1987, of the rigid reference, of motions made up for the purpose."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxstick.outcome import BAND, Outcome, outcome
from tests.jaxstick.rig1987_runs import RIG, STOPS, motions
from tests.reference import rig1987, rigid

NATURAL = RIG.natural_frequency


def looked_at(displacement: np.ndarray, interval: float, frequency: float, cycles: int = 3) -> Outcome:
    return outcome(
        displacement, interval=interval, frequency=frequency, natural_frequency=NATURAL, cycles=cycles
    )


@pytest.mark.parametrize("dynamic_ratio", [0.85, 6.42 / 7.47, 0.90])
def test_the_stops_of_the_paper(dynamic_ratio):
    found = {ratio: looked_at(*motion).stops for ratio, motion in motions(dynamic_ratio).items()}
    assert found == STOPS


@pytest.mark.parametrize("level", [4e-4, 1e-3, 2e-3])
def test_noise_of_permilles_of_the_stroke_changes_no_count(level):
    random = np.random.default_rng(1)
    for ratio, (displacement, interval, frequency) in motions(6.42 / 7.47).items():
        noise = level * np.ptp(displacement) * random.standard_normal(len(displacement))
        assert looked_at(displacement + noise, interval, frequency).stops == STOPS[ratio]


@pytest.mark.parametrize("ratio", [0.035, 0.06, 0.085, 0.14, 0.25, 0.32, 0.6, 1.1])
def test_as_many_stops_as_the_rigid_contact_has_stick_intervals(ratio):
    drive = rig1987.drive(ratio)
    cycles, per_cycle = max(8, round(25 * ratio)), max(400, round(60 / ratio))
    first = (cycles - 2) * drive.period
    times = np.concatenate([[0.0], np.linspace(first, cycles * drive.period, 2 * per_cycle + 1)])
    run = rigid.simulate(rig1987.rig(), drive, times)
    found = looked_at(run.x[1:-1], drive.period / per_cycle, drive.frequency)
    assert found.stops == run.count("stick", first, cycles * drive.period) / 2
    assert found.amplitude == pytest.approx(np.ptp(run.x[1:]) / 2, rel=1e-9)
    stuck = np.mean(run.v[1:] == 0.0)
    assert stuck - 0.02 < found.stick_fraction < stuck + 0.16


@given(
    ratio=st.floats(0.04, 3.0),
    phase=st.floats(0.0, 6.3),
    noise=st.sampled_from([0.0, 4e-4]),
    cycles=st.integers(1, 4),
)
def test_a_smooth_motion_has_no_stops(ratio, phase, noise, cycles):
    frequency = ratio * NATURAL
    interval = min(1 / 500, 1 / frequency / 60)
    time = interval * np.arange(round((cycles + 0.4) / frequency / interval))
    motion = 0.01 * np.sin(2 * math.pi * frequency * time + phase)
    motion += 0.02 * noise * np.random.default_rng(0).standard_normal(len(time))
    found = looked_at(motion, interval, frequency)
    assert found.stops == 0
    assert found.stick_fraction == 0
    assert found.amplitude == pytest.approx(0.01, rel=5e-3)


def staircase(per_cycle: int, steps: int, ring: float = 0.0) -> np.ndarray:
    """One cycle, up and down in smooth slips between `steps` stops each way, the upper and the lower end
    shared: 2 steps - 2 stops in all, on which the contact may ring."""
    levels = np.concatenate([np.arange(steps), np.arange(steps - 2, 0, -1)]) / (steps - 1)
    each = per_cycle // len(levels)
    phase = np.linspace(0.0, 1.0, each, endpoint=False)
    slip = np.clip((phase - 0.6) / 0.4, 0.0, 1.0)
    shape = slip**2 * (3 - 2 * slip)
    after = np.roll(levels, -1)
    cycle = (levels[:, None] + (after - levels)[:, None] * shape).ravel()
    return 2 * cycle - 1 + ring * np.tile((slip == 0) * np.sin(40 * phase), len(levels))


@given(
    steps=st.integers(2, 40),
    shift=st.integers(0, 5000),
    scale=st.floats(1e-9, 1e3),
    offset=st.floats(-3.0, 3.0),
    sign=st.sampled_from([-1.0, 1.0]),
)
def test_neither_scale_nor_zero_nor_a_shift_by_whole_samples_matters(steps, shift, scale, offset, sign):
    per_cycle = 80 * (2 * steps - 2)
    motion = np.tile(staircase(per_cycle, steps), 2)
    known = {"interval": 1e-3, "frequency": 1e3 / per_cycle, "natural_frequency": 24.0}
    still = outcome(motion, **known)
    assert still.stops == 2 * steps - 2
    moved = outcome(sign * scale * (np.roll(motion, shift) + offset), **known)
    assert (moved.stops, moved.cycles) == (still.stops, still.cycles)
    assert moved.amplitude == pytest.approx(scale * still.amplitude, rel=1e-6)
    assert moved.stick_fraction == pytest.approx(still.stick_fraction, abs=4 / per_cycle)


def test_the_ring_of_the_contact_does_not_divide_a_stop():
    motion = np.tile(staircase(240 * 4, 3, ring=0.4 * BAND), 3)
    assert outcome(motion, interval=1e-3, frequency=1e3 / 960, natural_frequency=8.0).stops == 4


def test_stops_with_less_slip_between_them_than_the_band_are_one():
    motion = np.tile(staircase(240 * 4, 3), 3)
    level = np.where(np.abs(motion - 1) < 1e-12, 1.0, 0.0)
    nudged = motion + 0.8 * BAND * level * (np.cumsum(level) % 144 < 72)
    assert outcome(nudged, interval=1e-3, frequency=1e3 / 960, natural_frequency=8.0).stops == 4


def test_a_slip_that_only_slows_down_is_no_stop_and_one_that_touches_standstill_is():
    time = np.linspace(0.0, 1.0, 2000, endpoint=False)
    angle = 2 * math.pi * time
    for share, stops in ((0.2, 0), (1.0, 2)):
        # x' = cos(angle) - share cos(3 angle) vanishes at angle 0, with zero slope, where share is 1.
        motion = np.tile(np.sin(angle) - share * np.sin(3 * angle) / 3, 2)
        found = outcome(motion, interval=5e-4, frequency=1.0, natural_frequency=2.0)
        assert found.stops == stops


def test_only_the_last_cycles_count():
    motion = np.concatenate([5 * np.sin(np.linspace(0, 4 * math.pi, 400)), np.zeros(200), np.ones(200)])
    known: dict[str, Any] = {"interval": 0.005, "frequency": 1.0, "natural_frequency": 4.0}
    assert outcome(motion, **known).cycles == 4
    assert outcome(motion, **known, cycles=2).amplitude == 0.5
    assert outcome(motion, **known, cycles=9).cycles == 4
    assert outcome(motion, **known, cycles=1) == Outcome(0.0, 0.0, 1.0, 1)


def test_a_mass_without_springs_counts_by_the_cycle():
    motion = np.tile(staircase(960, 3), 3)
    assert outcome(motion, interval=1e-3, frequency=1e3 / 960, natural_frequency=0.0).stops == 4


@pytest.mark.parametrize(
    "wrong",
    [{"interval": 0.0}, {"frequency": -1.0}, {"natural_frequency": -1.0}, {"frequency": 0.9}],
)
def test_what_makes_no_sense_is_refused(wrong):
    known = {"interval": 0.01, "frequency": 1.0, "natural_frequency": 4.0} | wrong
    with pytest.raises(ValueError, match=r"makes no sense|less than a cycle"):
        outcome(np.sin(np.arange(101.0)), **known)
