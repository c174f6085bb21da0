"""Single effects against none and against one another."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.judging.single import SHAPES, Single, singly

ONE, OTHER = ("one",), ("other",)

amounts = st.floats(0.0, 500.0, allow_subnormal=False)


@given(st.lists(st.tuples(amounts, amounts, st.floats(1.0, 30.0), amounts), min_size=1, max_size=8), amounts)
def test_whether_one_acts_does_not_depend_on_which_does(effects, most):
    """All together they are as likely as by all the evidence there is."""
    singles = {
        (f"effect {n}",): Single(price, behind, behind / share, cheaper)
        for n, (price, behind, share, cheaper) in enumerate(effects)
    }
    found = math.fsum(math.exp(log) for log in singly(singles, most).values())
    wanted = math.fsum(math.exp(-one.behind - one.price) for one in singles.values())
    assert found == pytest.approx(wanted, rel=1e-6, abs=1e-300)


def test_similar_effects_are_told_apart_by_less():
    """A strong one, of which another leaves a hundredth: by what counts among them."""
    found = singly({ONE: Single(0.0, 0.0, 0.0), OTHER: Single(0.0, 10.0, 1.0)}, 1000.0)
    assert found[ONE] - found[OTHER] == pytest.approx(1.0)


def test_where_there_is_little_a_good_part_of_it_tells():
    weak = {ONE: Single(0.0, 0.0, 0.0), OTHER: Single(0.0, 9.0, 0.9)}
    found = singly(weak, 10.0)
    assert found[ONE] - found[OTHER] == pytest.approx(9.0)
    half = singly({**weak, OTHER: Single(0.0, 1.0, 0.1)}, 10.0)
    assert half[ONE] - half[OTHER] == pytest.approx(0.5 * (0.1 / SHAPES) ** 2)


def test_what_leaves_no_more_than_the_best_lies_behind_by_nothing():
    found = singly({ONE: Single(1.0, 0.0, 0.0), OTHER: Single(4.0, 0.0, 0.0)}, 0.0)
    assert found[ONE] - found[OTHER] == pytest.approx(3.0)
    assert singly({}, 3.0) == {}


def test_a_parameter_more_costs_less_among_them():
    found = singly({ONE: Single(2.0, 0.0, 0.0, 1.0), OTHER: Single(5.0, 0.0, 0.0, 2.5)}, 100.0)
    assert found[ONE] - found[OTHER] == pytest.approx(1.5)
