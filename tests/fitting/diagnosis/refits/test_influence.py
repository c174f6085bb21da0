"""How much a single lane says for an explanation."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.refits.influence import ENOUGH, heard, spared, told_by_many

COUNTED = 100.0
COSTS = st.lists(st.tuples(st.floats(1.0, 300.0), st.floats(1.0, 300.0)), min_size=2, max_size=40)


@given(COSTS)
def test_no_lane_gains_more_than_all_others_together_where_these_gain_little(costs):
    before, cost = np.array(costs).T
    counted = heard(before, cost)
    gained = before - counted
    loudest = int(np.argmax(before - cost))
    rest = gained.sum() - gained[loudest]
    assert rest >= ENOUGH * (1 - 1e-9) or gained[loudest] <= max(rest, 0.0) + 1e-9 * before.sum()
    others = np.delete(np.arange(len(cost)), loudest)
    assert np.array_equal(counted[others], cost[others]) and cost[loudest] <= counted[loudest]


@given(COSTS)
def test_no_lane_keeps_more_than_all_others_together(costs):
    """Nor is anything taken from the others, or more than what is beyond the noise."""
    cost, dof = np.array(costs).T
    counted = spared(cost, dof)
    loudest = int(np.argmax(cost - dof))
    others = np.delete(np.arange(len(cost)), loudest)
    rest = float((cost - dof)[others].sum())
    assert counted[loudest] - dof[loudest] <= max(rest, 0.0) + 1e-9 * cost.sum()
    assert np.array_equal(counted[others], cost[others]) and counted[loudest] <= cost[loudest]
    if (cost - dof)[loudest] <= rest:
        assert np.array_equal(counted, cost)


def refit(cost: np.ndarray, price: float = 1.0) -> Any:
    return SimpleNamespace(cost=cost, price=lambda bench: price)


def told(cost: np.ndarray, *against: np.ndarray, price: float = 1.0) -> float:
    bench: Any = SimpleNamespace(dof=lambda: np.full(len(cost), COUNTED))
    return told_by_many(bench, refit(cost, price), [refit(other) for other in against])


def test_what_one_lane_alone_tells_is_not_believed():
    """And what many do is, to the last digit; what friction that wanders costs stays as it is."""
    before = np.full(60, 1.1 * COUNTED)
    before[7] += 66.0
    alone, many = before.copy(), before - 1.5
    alone[7] -= 66.0
    assert told(alone, before) == pytest.approx(told(before))
    assert told(many, before) == pytest.approx(many.sum() / (60 * COUNTED))
    assert told(many, before, price=1.1) == pytest.approx(1.1 * told(many, before))


def test_a_lane_that_the_nominal_model_loses_outright_does_not_silence_the_others():
    """It counts as little for an explanation as it does in every misfit."""
    before = np.full(60, 6 * COUNTED)
    before[7] = 1e6
    found = np.full(60, 1.05 * COUNTED)
    assert told(found, before) == pytest.approx(1.05)


def test_a_lane_that_no_explanation_follows_does_not_speak_against_one():
    """Where all others are at their noise it says nothing, where a gap is in many as much as these."""
    fitted = np.full(60, COUNTED)
    fitted[7] = 60 * COUNTED
    assert told(fitted, np.full(60, 5 * COUNTED)) == pytest.approx(1.0)
    some = np.full(60, 1.5 * COUNTED)
    assert told(some) == pytest.approx(1.5)
    some[7] += COUNTED
    assert told(some) == pytest.approx(1.5 + 1 / 60)


def test_a_second_effect_is_told_by_more_than_one_lane_too():
    before = np.full(60, 9 * COUNTED)
    first = np.full(60, 1.2 * COUNTED)
    both = first.copy()
    both[3] = COUNTED
    assert told(both, before) < told(first, before)
    assert told(both, before, first) == pytest.approx(told(first, before))
