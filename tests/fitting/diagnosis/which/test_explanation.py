"""How far apart explanations are."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from fitting.diagnosis.which.explanation import TOLD_APART, separation, told_apart

LANES = 40


def explained(cost: np.ndarray) -> Any:
    return SimpleNamespace(refit=SimpleNamespace(cost=cost))


def test_of_a_pair_that_is_just_told_apart_one_in_twenty_is_taken_for_the_other():
    assert norm.cdf(-TOLD_APART / 2) == pytest.approx(0.05, abs=0.001)


def test_the_separation_is_half_of_d_prime():
    """With unit noise, what lies d' away costs d'^2 more on average, and is mistaken where noise makes it the
    cheaper one: in Phi(-d'/2) of cases, Phi of minus the separation on average."""
    random = np.random.default_rng(5)
    lacking = np.full(LANES, 2.4 / np.sqrt(LANES))
    noise = random.standard_normal((4000, LANES))
    pairs = [(explained(own**2), explained((own + lacking) ** 2)) for own in noise]
    found = [separation(*pair) for pair in pairs]
    assert np.mean(found) == pytest.approx(1.2, rel=0.05)
    assert np.mean(np.array(found) < 0) == pytest.approx(norm.cdf(-1.2), abs=0.015)


@pytest.mark.parametrize(
    ("lacking", "apart"), [([0.5], True), ([0.1], False), ([0.0], False), ([20.0, *[0.0] * 39], False)]
)
def test_what_leaves_as_little_and_what_one_segment_tells_is_not_told_apart(lacking, apart):
    cost = np.full(LANES, 10.0)
    one, other = explained(cost), explained(cost + np.tile(lacking, LANES // len(lacking))[:LANES])
    assert told_apart(one, other) == told_apart(other, one) == apart
