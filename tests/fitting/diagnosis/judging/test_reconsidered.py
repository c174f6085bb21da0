"""Judgements reconsidered once runs that took no part have spoken."""

from __future__ import annotations

import dataclasses

import pytest

from fitting.diagnosis.judging.judge import judge
from fitting.diagnosis.judging.reconsidered import astray, refuted, succeeded, weighed_again
from fitting.diagnosis.judging.single import AMONG
from tests.fitting.diagnosis.judged import SAMPLES, SHELF, account, both


def test_what_took_no_part_takes_back_or_confirms_that_friction_is_steadier():
    """No more than there was to take back, from all alike; what rests on something else stays as it is.
    Exactly so where as much tells which effect acts as whether any does."""
    drift = dataclasses.replace(account(0, 1.05), steadier=6.5)
    other = dataclasses.replace(account(1, 1.05), steadier=3.0)
    found = judge(1.06, [drift, other, account(2, 1.045)], SAMPLES, AMONG, SHELF)
    assert found.named == (SHELF[0],)
    again = weighed_again(found, drift.keys, -9.0)
    assert again.verdict == "none"
    plain = [account(0, 1.05), account(1, 1.05), account(2, 1.045)]
    assert again.effects == pytest.approx(judge(1.06, plain, SAMPLES, AMONG, SHELF).effects, abs=1e-9)
    assert weighed_again(found, drift.keys, 2.0).effects[SHELF[0]] > found.effects[SHELF[0]]
    for judgement in (again, found):
        assert sum(judgement.effects.values()) == pytest.approx(1.0)
        assert sum(judgement.explanations.values()) == pytest.approx(1.0)
    clear = judge(9.0, [account(0, 1.01), account(1, 4.0)], SAMPLES, 1.5, SHELF)
    assert weighed_again(clear, clear.named, -30.0).effects == pytest.approx(clear.effects)


def test_two_effects_are_confirmed_by_what_runs_say_of_them_that_took_no_part_not_by_what_they_say_of_one():
    """These confirm one effect in full, and find friction no steadier with two."""
    first = dataclasses.replace(account(0, 0.99), steadier=20.0)
    two = dataclasses.replace(both(0.99), steadier=38.0, of_friction=(SHELF[1],))
    found = judge(6.0, [first, account(1, 5.0), two], SAMPLES, 100.0, SHELF)
    assert (found.verdict, found.named) == ("effect", first.keys)
    assert weighed_again(found, first.keys, 20.0).verdict == "several"
    again = weighed_again(found, first.keys, 20.0, {two.keys: 20.0})
    assert (again.verdict, again.named) == ("effect", first.keys)


@pytest.mark.parametrize("hidden", [(), SHELF])
def test_what_was_not_refitted_is_not_named_where_everything_else_is_taken_back(hidden):
    """Were it a hair's breadth of probability that nobody looked at: it is unlisted then."""
    steady = dataclasses.replace(account(0, 1.0), steadier=150.0, of_friction=(SHELF[0],))
    found = judge(30.0, [steady], SAMPLES, 40.0, SHELF, hidden=hidden)
    assert found.named == steady.keys
    again = weighed_again(found, steady.keys, -1000.0)
    assert (again.verdict, again.named) == ("unlisted", ())
    assert sum(again.effects.values()) == pytest.approx(1.0)


def test_segments_that_go_astray_are_not_nothing():
    """What effects are likely to be stays; where one is named, nothing changes."""
    found = judge(1.02, [account(0, 1.019), account(1, 1.0195)], SAMPLES, 2.0, SHELF)
    doubted = astray(found)
    assert (found.verdict, doubted.verdict) == ("none", "unlisted")
    assert sum(doubted.explanations.values()) == pytest.approx(1.0)
    assert doubted.effects[SHELF[0]] == found.effects[SHELF[0]]
    assert doubted.effects["none"] == pytest.approx(0.1 * found.effects["none"])
    clear = judge(9.0, [account(0, 1.01), account(1, 4.0)], SAMPLES, 1.5, SHELF)
    assert astray(clear).named == clear.named == (SHELF[0],)


def test_what_other_runs_refute_is_unlisted():
    """What is left to the effects keeps its order; "none" is not touched."""
    found = judge(9.0, [account(0, 1.01), account(1, 4.0), account(2, 8.5)], SAMPLES, 1.5, SHELF)
    doubted = refuted(found)
    assert (doubted.verdict, doubted.named) == ("unlisted", ())
    assert doubted.effects["unlisted"] > 0.85
    for before, after in (
        (found.effects, doubted.effects),
        (found.explanations, doubted.explanations),
    ):
        assert sum(after.values()) == pytest.approx(1.0)
        assert after["none"] == before["none"]
        assert after[SHELF[0]] == pytest.approx(0.1 * before[SHELF[0]])


def test_what_other_runs_do_not_call_for_is_none():
    """Scores that are too high for chance and too small to matter: what was the effects' goes to "none"."""
    found = judge(0.968, [account(0, 0.9636), account(1, 0.9674, 3)], SAMPLES, 1.0, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))
    doubted = refuted(found, "none")
    assert (doubted.verdict, doubted.named) == ("none", ())
    assert doubted.effects["unlisted"] == found.effects["unlisted"]
    assert sum(doubted.effects.values()) == pytest.approx(1.0)


def test_what_other_runs_speak_for_succeeds_what_they_speak_against():
    """The rest of the answers keep what they have."""
    found = judge(1.3, [account(0, 1.02), account(1, 1.01, 3), account(2, 1.25)], SAMPLES, 40.0, SHELF)
    assert found.taken == (SHELF[0],)
    after = succeeded(found, (SHELF[0],), (SHELF[1],))
    assert (after.verdict, after.named) == ("effect", (SHELF[1],))
    assert after.effects[SHELF[0]] == pytest.approx(0.05 * found.effects[SHELF[0]])
    assert sum(after.explanations.values()) == pytest.approx(1.0)
    for other in ("none", "unlisted", SHELF[2]):
        assert after.effects[other] == pytest.approx(found.effects[other])
