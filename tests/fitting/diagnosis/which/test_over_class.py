"""Constants of a class of effects that no record tells apart."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.over_class import AS_GOOD, under_others, widened
from fitting.result import Constant

NAMES = ("C", "k1", "force_gain.gain")
TIMES = some.lists(some.floats(0.5, 2.0), max_size=3)


def values(coordinates: np.ndarray, names: Sequence[str]) -> dict[str, float]:
    """Parameters whose coordinates are their logarithms to the base 2."""
    return {name: 2.0 ** coordinates[NAMES.index(name)] for name in names}


MODEL: Any = SimpleNamespace(names=NAMES, values=values)


def explanation(*keys: str, coordinates: tuple[float, ...], misfit: float = 1.0) -> Explanation:
    refit: Any = SimpleNamespace(
        point=SimpleNamespace(coordinates=np.array(coordinates)), free=np.array([0, 1]), misfit=misfit
    )
    promise: Any = None
    return Explanation(keys, promise, refit)


def attribution(same: tuple[tuple[str, ...], ...], *found: Explanation) -> Any:
    return SimpleNamespace(judgement=SimpleNamespace(same=same), explanations=found)


def constant(value: float, low: float | None, high: float | None, name: str = "C") -> Constant:
    error = None if low is None or high is None else (high - low) / 4
    return Constant(name, value, low, high, "N", 1.0, error, "covariance")


def test_constants_are_compared_with_those_under_the_other_effects_of_a_class():
    """Only where one effect stands in the place of another, and the records are explained as well."""
    named = explanation("force_gain", "hum", coordinates=(3.0, 5.0, 0.0))
    other = explanation("hum", "stiffness", coordinates=(4.0, 4.5, 0.0))
    worse = explanation("base_gain", "hum", coordinates=(9.0, 9.0, 0.0), misfit=1.01 * AS_GOOD)
    alone = explanation("stiffness", coordinates=(7.0, 7.0, 0.0))
    found = attribution((("force_gain", "stiffness", "base_gain"),), named, other, worse, alone)
    (times,) = under_others(MODEL, found, named)
    assert times == pytest.approx({"C": 2.0, "k1": 2.0**-0.5})
    assert under_others(MODEL, attribution((), named, other), named) == []


@given(some.floats(0.5, 3.0), some.floats(0.01, 0.4), TIMES)
def test_intervals_hold_what_constants_are_under_each(value, half, times):
    before = constant(value, value - half, value + half)
    found = widened(before, [{"C": factor} for factor in times])
    assert found.value == value
    assert found.low is not None and found.high is not None and found.standard_error is not None
    for factor in (1.0, *times):
        assert found.low <= factor * value <= found.high
    assert found.standard_error == pytest.approx((found.high - found.low) / 4)


def test_what_is_not_bounded_and_what_others_do_not_change_stays():
    apart = [constant(1.0, None, 1.2), constant(1.0, 0.9, 1.1, "D")]
    assert [widened(one, [{"C": 3.0}]) for one in apart] == apart
