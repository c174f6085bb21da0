"""How the levels of friction go on from lane to lane says whether an effect makes it keep still."""

from __future__ import annotations

import numpy as np
import pytest

from fitting.diagnosis.lanes.steadiness import Levels, steadier

RUNS, LANES = 4, 16
RUN = np.repeat(np.arange(RUNS), LANES)
LANE = np.tile(np.arange(LANES), RUNS)
NOISE = 0.004
DRIFT = 0.01


def levels(values: np.ndarray, noise: float = NOISE) -> Levels:
    return Levels(values, np.full(len(values), noise**2), np.ones(len(values), bool))


def wandering(seed: int, length: float, scale: float = 0.03) -> np.ndarray:
    """Levels whose correlation falls to 1/e in so many lanes, which differ from run to run."""
    random = np.random.default_rng(seed)
    keeps = np.exp(-1 / length)
    out = np.empty((RUNS, LANES))
    out[:, 0] = random.standard_normal(RUNS)
    for lane in range(1, LANES):
        out[:, lane] = keeps * out[:, lane - 1] + np.sqrt(1 - keeps**2) * random.standard_normal(RUNS)
    return scale * out.ravel() + 0.2 * random.standard_normal(RUNS)[RUN]


def white(seed: int) -> np.ndarray:
    return NOISE * np.random.default_rng(seed).standard_normal(RUNS * LANES)


def slope(values: np.ndarray) -> float:
    """What all runs have of a drift, by least squares."""
    centred = LANE - LANE.mean()
    return float(centred @ values / (centred @ centred))


def test_what_all_runs_have_in_common_is_told_from_wandering():
    before = DRIFT * LANE + white(1)
    assert steadier(levels(before), levels(before - slope(before) * LANE), RUN) > 50


@pytest.mark.parametrize("length", [0.1, 4.0, 30.0])
def test_a_drift_that_is_read_into_wandering_is_hardly_worth_anything(length: float):
    """In 4 runs of 100 at most it is worth more than what a parameter costs twice."""
    worth = []
    for seed in range(100):
        before = wandering(seed, length) + white(seed + 1000)
        worth.append(steadier(levels(before), levels(before - slope(before) * LANE), RUN))
    assert np.median(worth) < 0.7
    assert np.sum(np.array(worth) > 4.0) <= 4


def test_what_makes_friction_wander_more_speaks_against_itself():
    quiet = levels(white(2))
    assert steadier(quiet, levels(quiet.best + wandering(3, 4.0)), RUN) < -20


def test_a_few_lanes_that_stray_do_not_decide():
    """Two of 64 lie a fifth off before, by an event that was lost, and not after; friction wanders alike."""
    worth = []
    for seed in range(20):
        after = wandering(seed, 3.0, 0.01) + white(seed + 1000)
        before = after.copy()
        before[[5, 40]] -= 0.2
        worth.append(steadier(levels(before), levels(after), RUN))
    assert np.median(worth) < 6.0 and max(worth) < 25.0


def test_lanes_that_do_not_count_and_levels_of_whole_runs_say_nothing():
    before = DRIFT * LANE + white(4)
    after = before - DRIFT * LANE
    plain = steadier(levels(before), levels(after), RUN)
    assert steadier(levels(before), levels(after + 0.05 * RUN), RUN) == pytest.approx(plain, abs=0.05)
    lost = np.arange(len(RUN)) % 11 == 0
    known = levels(before)._replace(counts=~lost)
    spoilt = np.where(lost, 7.0, after)
    assert steadier(known, levels(spoilt), RUN) == steadier(known, levels(after), RUN) > 50


@pytest.mark.parametrize("level", [np.nan, 1.8, -16.0])
def test_a_lane_that_has_lost_an_event_says_nothing(level: float):
    """Neither before, where it would be to the credit of every effect, nor after, where it would take it."""
    before = DRIFT * LANE + white(5)
    after = before - DRIFT * LANE
    lost = np.arange(len(RUN)) == 3
    without = steadier(levels(before)._replace(counts=~lost), levels(after), RUN)
    assert steadier(levels(before), levels(np.where(lost, level, after)), RUN) == without > 50
    assert steadier(levels(np.where(lost, level, before)), levels(before), RUN) == 0.0


def test_what_is_compared_is_compared_in_the_same_lanes():
    """Two effects make friction as steady, and one of them has lost the event in a lane that showed much."""
    lost = np.arange(len(RUN)) == 7
    before = DRIFT * LANE + np.where(lost, 0.05, 0.0) + white(6)
    after = levels(white(6))
    astray = levels(np.where(lost, 1.8, after.best))
    assert steadier(levels(before), after, RUN) > steadier(levels(before), astray, RUN) + 3
    known = levels(before).where_none_lost([after, astray])
    assert steadier(known, after, RUN) == steadier(known, astray, RUN) > 50
