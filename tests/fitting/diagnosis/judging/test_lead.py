"""One effect that explains far more than every other is itself, in another shape."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.accounts import Account
from fitting.diagnosis.judging.judge import judge
from fitting.diagnosis.judging.lead import MOST, lead

SHELF = [f"effect_{n}" for n in range(36)]


def account(number: int, misfit: float, steadier: float = 0.0) -> Account:
    return Account((SHELF[number],), misfit, 2, steadier=steadier)


def test_a_lead_grows_with_every_halving_up_to_a_bound():
    found = [lead({"a": 1 + 8 * share, "b": 1 + 8 * 0.5}, 9.0, {}) for share in (0.8, 0.25, 0.2, 0.01)]
    assert found[0] == 0
    assert 0 < found[1] < found[2] < found[3] == MOST
    assert lead({"a": 1 + 8 * 0.36, "b": 9.0}, 9.0, {}) == 0


def test_it_is_no_lead_over_what_no_record_tells_from_it():
    left = {"a": 1.8, "b": 1.81, "c": 8.0}
    assert lead(left, 9.0, {}) == 0
    assert lead(left, 9.0, {"a": ("b",)}) > 3


@given(
    st.dictionaries(st.sampled_from(SHELF), st.floats(0.5, 200.0), max_size=6),
    st.floats(0.5, 200.0),
)
def test_it_is_never_evidence_for_what_is_off_the_shelf(left, nominal):
    found = lead(left, nominal, {})
    assert 0 <= found <= MOST
    if nominal < 1.1:
        assert found == 0


@pytest.mark.parametrize(("second", "verdict"), [(5.0, "effect"), (2.2, "unlisted")])
def test_what_stands_apart_is_named_in_another_shape_than_the_shelf_has(second, verdict):
    """It leaves a fifth of the excess."""
    found = judge(5.75, [account(0, 1.95), account(1, second), account(2, 5.6)], 1e4, 4.0, SHELF)
    assert (found.verdict, found.named) == (verdict, (SHELF[0],) if verdict == "effect" else ())


def test_steady_friction_under_what_explains_nothing_is_no_evidence_for_what_is_off_the_shelf():
    """Not where another effect explains most."""
    left = [account(0, 1.34), account(1, 4.0, steadier=6.8), account(2, 3.9)]
    two = Account(tuple(SHELF[:2]), 1.331, 5, steadier=5.8, of_friction=(SHELF[1],))
    found = judge(4.02, [*left, two], 1e4, 44.0, SHELF, hidden=SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))
