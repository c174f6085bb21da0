"""Effects that no record tells apart, and how their class shares its probability."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.judging.one_class import AT_MOST, classes, shared
from jaxstick.catalogue import catalogue

TRACES = {
    "gain": ("scale",),
    "other gain": ("scale",),
    "rig": ("scale", "drive"),
    "base": ("drive",),
    "spring": (),
}


def test_a_class_is_all_that_leaves_the_same_trace():
    found = classes(TRACES, {})
    assert found["gain",] == ("other gain", "rig") and found["base",] == ("rig",)
    assert ("spring",) not in found


def test_of_two_traces_the_one_counts_that_others_come_close_by():
    gain, base = frozenset({"gain"}), frozenset({"base"})
    assert classes(TRACES, {gain: 3.0, base: 2.0})["rig",] == ("base",)
    assert classes(TRACES, {gain: 3.0, base: 4.0})["rig",] == ("gain", "other gain")


def test_beside_another_effect_the_same_counts_there():
    alone = {frozenset({"gain"}): 3.0, frozenset({"base"}): 2.0}
    pairs = {frozenset({"rig", "spring"}): 1.0, frozenset({"gain", "spring"}): 1.1}
    found = classes(TRACES, alone | pairs)
    assert found["rig",] == ("base",) and found["rig", "spring"] == ("gain", "other gain")
    assert ("spring", "rig") not in found


def test_what_acts_beside_an_effect_is_not_taken_for_it():
    found = classes(TRACES, {frozenset({"gain", "rig"}): 1.0})
    assert found["gain", "rig"] == ("other gain",)


@given(st.lists(st.floats(0.0, 1.0, allow_subnormal=False), min_size=2, max_size=4))
def test_no_member_of_a_class_is_all_but_certain_and_none_is_left_out(weights):
    whole = sum(weights) + 1.0
    probabilities = {str(n): weight / whole for n, weight in enumerate(weights)} | {"else": 1 / whole}
    members = [str(n) for n in range(len(weights))]
    found = shared(probabilities, members)
    total = sum(weights) / whole
    assert found["else"] == probabilities["else"]
    assert sum(found.values()) == pytest.approx(1.0)
    assert max(found[key] for key in members) <= AT_MOST * total + 1e-12
    assert min(found[key] for key in members) >= 0.1 * total - 1e-12
    for one in members:
        for other in members:
            if probabilities[one] > probabilities[other]:
                assert found[one] >= found[other]


def test_the_shelf_has_the_classes_that_theory_says():
    """A gain of F and one of x; damping against the base and a shift of y in time (issue: exact aliases)."""
    found = classes({key: effect.traces for key, effect in catalogue().items()}, {})
    assert "displacement_gain" in found["force_gain",] and "force_gain" in found["displacement_gain",]
    assert found["base_delay",] == ("base_relative_damping",)
    assert found["base_relative_damping",] == ("base_delay",)
    assert found["base_gain",] == ("stiffness_error",)
