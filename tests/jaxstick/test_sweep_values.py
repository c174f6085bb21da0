"""How the values of a sweep's axis are written."""

from __future__ import annotations

import numpy as np
import pytest

from jaxstick.sweeps.values import MOST, values_of


def test_numbers_and_ranges():
    assert values_of("8, 10.325") == (8.0, 10.325)
    assert values_of("0.04:1.0:400") == tuple(np.linspace(0.04, 1.0, 400))
    assert values_of("1:0:3") == (1.0, 0.5, 0.0)
    assert values_of("3:3:1") == (3.0,)
    assert values_of("0.1:0.2:3,0.5") == pytest.approx((0.1, 0.15, 0.2, 0.5))
    assert values_of("1e-2:1:3:log") == pytest.approx((0.01, 0.1, 1.0))


def test_a_value_that_comes_up_again_counts_once():
    assert values_of("1:2:3,2:3:3,1") == (1.0, 1.5, 2.0, 2.5, 3.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "'', which is not a finite number"),
        ("1,,2", "'', which is not a finite number"),
        ("a", "'a', which is not a finite number"),
        ("nan", "'nan', which is not"),
        ("1:inf:3", "'inf', which is not"),
        ("0.04:1.0", "is not low:high:count"),
        ("1:2:3:4", "is not low:high:count"),
        ("1:2:3:lin", "is not low:high:count"),
        ("1:2:0", "a whole number from 1 on"),
        ("1:2:-5", "a whole number from 1 on"),
        ("1:2:2.5", "a whole number from 1 on"),
        ("1:2:1", "of one value only"),
        ("0:2:3:log", "not both positive"),
        (f"0:1:{MOST + 1}", "more than 10000000 values"),
        ("0:1:1e300", "more than 10000000 values"),
    ],
)
def test_what_is_no_axis_is_refused(text, words):
    with pytest.raises(ValueError, match=r"^(has|asks)") as caught:
        values_of(text)
    assert words in str(caught.value)
