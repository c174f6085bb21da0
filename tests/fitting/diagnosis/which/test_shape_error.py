"""What a shape that is not quite right leaves open."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.shape_error import CHANCE, shape_variance

FREE = np.array([0, 2])


def explanation(keys: str, misfit: float, *coordinates: float) -> Explanation:
    """Effects, joined with +, what they leave, and where their refit ended."""
    refit: Any = SimpleNamespace(
        point=SimpleNamespace(coordinates=np.array(coordinates)), free=FREE, misfit=misfit
    )
    promise: Any = None
    return Explanation(tuple(keys.split("+")), promise, refit)


def attribution(*found: Explanation, inflation: float = 5.0) -> Any:
    return SimpleNamespace(
        explanations=found, floor=1.0, inflation=inflation, yardstick=SimpleNamespace(samples=10000.0)
    )


NAMED = explanation("a", 1.4, 0.0, 0.0, 1.0)
MENDS = explanation("a+b", 1.2, 0.3, 9.0, 1.4)
MENDS_LESS = explanation("c+a", 1.3, -0.1, 9.0, 1.0)


def test_constants_are_as_uncertain_as_what_mends_the_shape_changes_them():
    """Mean squares, weighed by a half and a quarter of what the effect leaves."""
    found = attribution(NAMED, MENDS, MENDS_LESS)
    expected = [(2 * 0.3**2 + 0.1**2) / 3, 2 * 0.4**2 / 3]
    assert shape_variance(found, NAMED) == pytest.approx(expected)


def test_what_does_not_belong_to_the_effect_or_mends_by_chance_says_nothing():
    others = [
        explanation("b+c", 1.1, 5.0, 5.0, 5.0),
        explanation("b", 1.2, 5.0, 5.0, 5.0),
        explanation("a+d", 1.4 * math.exp(-1.9 * CHANCE * 5 / 10000), 5.0, 5.0, 5.0),
        explanation("a+e", 1.5, 5.0, 5.0, 5.0),
    ]
    assert shape_variance(attribution(NAMED, *others), NAMED).tolist() == [0.0, 0.0]
    surely = explanation("a+d", 1.4 * math.exp(-2.1 * CHANCE * 5 / 10000), 5.0, 5.0, 5.0)
    assert (shape_variance(attribution(NAMED, *others, surely), NAMED) > 1).all()
    noisy = attribution(NAMED, *others, surely, inflation=50.0)
    assert shape_variance(noisy, NAMED).tolist() == [0.0, 0.0]


def test_nothing_is_mended_by_more_than_all():
    beyond = explanation("a+b", 0.9, 0.3, 9.0, 1.4)
    found = shape_variance(attribution(NAMED, beyond, MENDS_LESS), NAMED)
    assert found[1] == pytest.approx(0.4**2 / 1.25)
