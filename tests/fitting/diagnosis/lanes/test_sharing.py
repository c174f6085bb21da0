"""Which effects are attached together."""

from __future__ import annotations

from fitting.diagnosis.lanes.sharing import FEW, GROUP, Sharing
from jaxstick.catalogue import catalogue

SHELF = catalogue()
SHARING = Sharing.of(SHELF)


def test_every_effect_is_in_one_group_of_its_family():
    assert sorted(SHARING.whole) == sorted(SHELF)
    for group in SHARING.groups:
        assert len(group) <= GROUP and len({SHELF[key].card.family for key in group}) == 1


def test_no_more_is_attached_than_is_fitted_or_looked_at():
    """One effect comes with the group that it was screened in, two come alone; many are looked at beside
    others with the whole shelf attached, a few without."""
    first, second = SHARING.groups[:2]
    assert SHARING.fitted(first[:1]) == first and SHARING.fitted(()) == ()
    two = (second[0], first[0])
    assert SHARING.fitted(two) == SHARING.together(two) == (first[0], second[0])
    assert SHARING.seen(first[1:], first[:1]) == first
    assert SHARING.seen(second[:1], two) == SHARING.together(two)
    assert SHARING.seen(second[1:2], two) == (first[0], *second[:2])
    assert len(second) >= FEW and SHARING.seen(second, first[:1]) == SHARING.whole
