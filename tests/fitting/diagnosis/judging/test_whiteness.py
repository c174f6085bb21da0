"""What the nominal model leaves is the noise, taken for too little, where it is white."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.judging.judge import judge
from fitting.diagnosis.judging.whiteness import COLOURED, MUCH, WHITE, WORTH, whiteness
from tests.fitting.diagnosis.judged import SAMPLES, SHELF, account


@pytest.mark.parametrize(("inflation", "verdict"), [(1.05, "none"), (1.6, "unlisted")])
def test_what_no_effect_explains_is_noise_only_where_it_is_white(inflation, verdict):
    left = [account(0, 1.145), account(1, 1.146)]
    assert judge(1.147, left, 0.6 * SAMPLES, inflation, SHELF).verdict == verdict


def test_much_is_off_the_shelf_however_white_it_is():
    found = [judge(1.5, [account(0, 1.48)], SAMPLES, inflation, SHELF) for inflation in (1.0, 1.6)]
    assert found[0].effects == found[1].effects
    assert found[0].verdict == "unlisted"


@given(st.floats(0.5, 5.0), st.floats(0.5, 200.0))
def test_it_never_speaks_for_what_is_off_the_shelf(nominal, inflation):
    found = whiteness(nominal, inflation)
    assert 0 <= found <= WORTH
    if nominal >= MUCH or inflation >= COLOURED:
        assert found == 0
    if nominal <= 1.2 and inflation <= WHITE:
        assert found == WORTH
