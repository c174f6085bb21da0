"""From misfits to probabilities: what is named, what is not, and when it is left open."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.accounts import Account
from fitting.diagnosis.judging.enough import hints, leaves_nothing, suffices
from fitting.diagnosis.judging.judge import HIDDEN, LEAST_INFLATION, TAKEN_FOR, judge, pieces_of_evidence
from fitting.diagnosis.judging.single import AMONG
from fitting.diagnosis.judging.verdict import alternatives, verdict_of
from tests.fitting.diagnosis.judged import SAMPLES, SHELF, account, both


def test_no_gap_is_called_none():
    found = judge(1.0, [account(0, 0.9998), account(1, 0.9999, 3)], SAMPLES, 1.0, SHELF)
    assert (found.verdict, found.named) == ("none", ())
    assert found.effects["none"] > 0.95


def test_an_effect_that_closes_the_gap_is_named():
    found = judge(9.0, [account(0, 1.01), account(1, 4.0), account(2, 8.5)], SAMPLES, 1.5, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))
    assert found.effects[SHELF[0]] > 0.97


def test_what_nobody_thought_of_is_off_the_shelf_rather_than_one_of_the_others():
    found = judge(9.0, [account(0, 1.01), account(1, 4.0), account(2, 8.5)], SAMPLES, 1.5, SHELF)
    others = [p for key, p in found.effects.items() if key not in (SHELF[0], "unlisted")]
    assert found.effects["unlisted"] > 0.9 * sum(others) > 0


def test_two_that_close_it_alike_are_left_open():
    found = judge(9.0, [account(0, 1.01), account(1, 1.0101), account(2, 8.5)], SAMPLES, 1.5, SHELF)
    assert found.verdict == "ambiguous"
    assert set(found.named) == {SHELF[0], SHELF[1]}
    assert found.effects[SHELF[0]] == pytest.approx(0.5, abs=0.3)


def test_two_that_differ_by_less_than_instruments_do_are_left_open_yet_told_from_none():
    found = judge(2.0, [account(0, 0.956, 2), account(1, 0.972)], SAMPLES / 2, 1.5, SHELF)
    assert (found.verdict, {*found.named}) == ("ambiguous", {SHELF[0], SHELF[1]})
    slight = judge(1.03, [account(0, 1.0), account(1, 1.028)], SAMPLES / 2, 1.5, SHELF)
    assert slight.verdict == "effect" and slight.effects["none"] < 0.1


@pytest.mark.parametrize("level", [0.95, 1.0, 1.03])
def test_a_weak_effect_is_named_however_well_the_noise_is_known(level):
    """It takes away nearly all that any does, and the others hardly anything."""
    left = [account(0, 1.0 * level, 2), account(1, 1.0123 * level, 3), account(2, 1.012 * level)]
    found = judge(1.013 * level, left, SAMPLES / 2, 1.3, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))


@pytest.mark.parametrize("price", [1, 3])
def test_what_is_off_the_shelf_is_not_asked_for_less_than_an_effect_of_a_weak_gap_is(price):
    """What is so weak might be left by either; only the effect has been seen to leave less."""
    left = [account(0, 1.0441, price), account(1, 1.0631, 3), account(2, 1.0638)]
    found = judge(1.0638, left, SAMPLES / 2, 1.05, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))


def test_no_effect_is_named_for_the_evidence_of_a_better_one_that_costs_more():
    left = [account(0, 1.015, 3), account(1, 1.0188), *(account(n, 1.0192) for n in range(2, 8))]
    found = judge(1.0216, left, SAMPLES / 2, 1.0, SHELF)
    assert found.verdict == "none"
    assert sum(found.effects[key] for key in SHELF) < 0.3


def test_a_filter_that_leaves_less_than_a_delay_is_not_ruled_out_for_its_one_parameter_more():
    left = [account(0, 0.8944, 2), account(1, 0.8995, 1), account(2, 2.29)]
    found = judge(2.843, left, SAMPLES / 2, 1.0, SHELF)
    assert found.verdict == "ambiguous" and {*found.named} == {SHELF[0], SHELF[1]}


def test_a_gap_that_nothing_closes_is_unlisted():
    found = judge(50.0, [account(0, 35.0), account(1, 40.0, 2)], SAMPLES, 20.0, SHELF)
    assert found.verdict == "unlisted"
    assert found.effects["unlisted"] > 0.8


def test_a_choice_between_many_effects_is_no_answer():
    """Against "unlisted" the two likeliest stand together; against "none" all do."""
    spread = {"unlisted": 0.4, "none": 0.0, **{SHELF[n]: 0.15 for n in range(4)}}
    assert verdict_of(spread) == ("unlisted", ())
    verdict, named = verdict_of({**spread, "unlisted": 0.28})
    assert verdict == "ambiguous" and set(named) == set(SHELF[:4])
    assert verdict_of({**spread, "unlisted": 0.0, "none": 0.4})[0] == "ambiguous"
    one_class = {(SHELF[n],): tuple(SHELF[m] for m in range(3) if m != n) for n in range(3)}
    assert verdict_of(spread, one_class)[0] == "ambiguous"


def test_an_effect_that_wandering_hides_is_named_for_the_steadiness_of_friction():
    """Its misfit is that of any other; a second effect has to make friction steadier by far to be named."""
    steady = dataclasses.replace(account(0, 1.05), steadier=16.0)
    found = judge(1.06, [steady, account(1, 1.045)], SAMPLES, 160.0, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))
    assert judge(1.06, [account(0, 1.05), account(1, 1.045)], SAMPLES, 160.0, SHELF).verdict == "none"
    joined = dataclasses.replace(both(1.045), steadier=22.0)
    beside = judge(1.06, [steady, account(1, 1.045), joined], SAMPLES, 160.0, SHELF)
    assert beside.named == (SHELF[0],)
    assert beside.explanations[f"{SHELF[0]}+{SHELF[1]}"] < 0.1
    for of_friction, verdict in ((SHELF[:2], "several"), (SHELF[1:2], "effect"), (SHELF[:1], "several")):
        joined = dataclasses.replace(both(1.045), steadier=56.0, of_friction=tuple(of_friction))
        beside = judge(1.06, [steady, account(1, 1.045), joined], SAMPLES, 160.0, SHELF)
        assert beside.verdict == verdict, of_friction


def test_steady_friction_is_no_evidence_for_what_leaves_far_more_than_another():
    """Nor for what is off the shelf."""
    bent = dataclasses.replace(account(1, 4.0), steadier=40.0)
    found = judge(9.0, [account(0, 1.01), bent, account(2, 8.5)], SAMPLES, 1.5, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))


@pytest.mark.parametrize(("left", "of_friction", "verdict"), [(2.1, 0, "effect"), (2.1, 2, "several")])
def test_steady_friction_is_no_evidence_for_a_second_that_does_not_change_it(left, of_friction, verdict):
    """Where it leaves far more alone: what it did for the levels then is the first one's doing."""
    first = dataclasses.replace(account(0, 0.99), steadier=6.0)
    second = dataclasses.replace(account(1, left), steadier=30.0)
    two = dataclasses.replace(both(0.99), steadier=40.0, of_friction=tuple(SHELF[:of_friction]))
    assert judge(1.9, [first, second, two], SAMPLES, 44.0, SHELF, hidden=SHELF).verdict == verdict


@pytest.mark.parametrize(("steadier", "verdict"), [(116.0, "effect"), (230.0, "several")])
def test_a_second_that_mends_the_shape_of_the_first_is_told_from_one_that_acts(steadier, verdict):
    """It makes friction a little steadier, too."""
    first = dataclasses.replace(account(0, 1.086), steadier=90.0)
    two = dataclasses.replace(both(1.067), steadier=steadier, of_friction=tuple(SHELF[:2]))
    assert judge(1.98, [first, account(1, 1.257), two], SAMPLES, 1.2, SHELF).verdict == verdict


def test_steady_friction_is_no_evidence_for_what_leaves_more_than_no_effect_at_all():
    """Such a search has ended elsewhere."""
    for misfit, verdict in ((0.87, "none"), (0.855, "effect")):
        steady = dataclasses.replace(account(0, misfit), steadier=16.0)
        assert judge(0.8547, [steady, account(1, 0.851)], SAMPLES, 160.0, SHELF).verdict == verdict


def test_steady_friction_does_not_tell_two_effects_from_one_of_them():
    """Where the two just belong to what leaves next to the least, and the one no more."""
    alone, spoilt = (dataclasses.replace(account(0, m), steadier=55.0) for m in (2.3, 19.0))
    pairs = [
        dataclasses.replace(Account((SHELF[0], SHELF[n]), m, 3), steadier=54.0)
        for n, m in ((1, 1.94), (2, 2.08))
    ]
    found = judge(273.0, [alone, *pairs, account(1, 9.9)], SAMPLES, 4.6, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))
    assert found.steadier[alone.keys] == 54.0
    assert judge(273.0, [spoilt, *pairs, account(1, 9.9)], SAMPLES, 4.6, SHELF).verdict == "several"


def test_a_pair_that_makes_friction_as_steady_and_leaves_less_is_worth_no_less():
    """Whether its second effect changes friction or the sensor that reads it."""
    alone = [account(0, 9.5, 1), dataclasses.replace(account(1, 38.0, 1), steadier=13.5)]
    sensor = dataclasses.replace(both(1.0), steadier=102.0)
    friction = Account((SHELF[0], SHELF[2]), 1.11, 3, steadier=81.0, of_friction=(SHELF[2],))
    found = judge(41.0, [*alone, account(2, 40.0), sensor, friction], 8400.0, 44.0, SHELF)
    assert (found.verdict, set(found.named)) == ("several", {SHELF[0], SHELF[1]})
    worse = dataclasses.replace(sensor, misfit=1.12)
    found = judge(41.0, [*alone, account(2, 40.0), worse, friction], 8400.0, 44.0, SHELF)
    assert (found.verdict, set(found.named)) == ("several", {SHELF[0], SHELF[2]})


@pytest.mark.parametrize(
    ("changing", "verdict"), [((1,), "several"), ((0, 1), "effect"), ((0,), "effect"), ((), "effect")]
)
def test_a_second_that_alone_changes_along_the_runs_mends_no_shape(changing, verdict):
    """All that friction is steadier for it counts."""
    first = dataclasses.replace(account(0, 0.99), steadier=30.0)
    two = dataclasses.replace(both(0.99), steadier=50.0, of_friction=(SHELF[1],))
    two = dataclasses.replace(two, changing=tuple(SHELF[n] for n in changing))
    assert judge(6.0, [first, account(1, 5.0), two], SAMPLES, 100.0, SHELF).verdict == verdict


def test_two_that_explain_nothing_are_not_named_for_costing_nothing():
    """Beside one that explains nearly all, with a shape that the records tell and that they pay for."""
    one = Account((SHELF[0],), 1.289, 5, shapes=(15000.0, 29.0, 0.41, 170.0))
    idle = Account((SHELF[1], SHELF[2]), 23.78, 5, shapes=(2e-8, 0.0, 7e-15))
    found = judge(23.777, [one, account(1, 23.796), account(2, 24.58), idle], SAMPLES / 2, 1.0, SHELF)
    assert (found.verdict, found.named) == ("effect", one.keys)
    assert found.explanations["+".join(idle.keys)] < 1e-3


def test_scatter_says_less_of_whether_an_effect_acts_but_not_of_which_does():
    """It hides either alike."""
    accounts = [account(0, 0.99), account(1, 1.02)]

    def judged(inflation: float) -> tuple[float, float]:
        p = judge(1.15, accounts, SAMPLES, inflation, SHELF).explanations
        return p["none"], p[SHELF[1]] / p[SHELF[0]]

    (none, odds), (hidden, other_odds) = judged(AMONG), judged(4 * AMONG)
    assert hidden > 3 * none
    assert other_odds == pytest.approx(odds, rel=0.02)


def test_scatter_hides_what_is_off_the_shelf_and_what_changes_friction():
    left = [account(0, 0.999), account(1, 0.999)]
    plain = judge(1.0, left, SAMPLES, 40.0, SHELF).effects
    found = judge(1.0, left, SAMPLES, 40.0, SHELF, hidden=SHELF[:2]).effects
    assert sum(found.values()) == pytest.approx(1.0)
    assert found["none"] < 0.85 * plain["none"] and found["unlisted"] > plain["unlisted"] + 0.05
    assert min(found[key] for key in SHELF[:2]) > 0.04
    assert found[SHELF[2]] < plain[SHELF[2]]


@pytest.mark.parametrize(("left", "named"), [(1.03954, (0, 1)), (1.042, (0, 2))])
def test_what_leaves_a_hundred_thousandth_more_is_worth_as_much(left, named):
    """Friction that drifts beside an offset, and beside a hum that comes to the same and has more to fit it
    with: alone of the two friction changes along the runs."""
    drift, offset, hum = SHELF[:3]
    alone = [dataclasses.replace(account(n, 1.142), steadier=38.5) for n in (1, 2)]
    made = [
        Account((drift, offset), left, 4, steadier=171.6, of_friction=(drift,), changing=(drift, offset)),
        Account((drift, hum), 1.03953, 10, steadier=171.58, of_friction=(drift,), changing=(drift,)),
    ]
    found = judge(6.0, [*alone, account(0, 5.9), *made], SAMPLES, 1.4, SHELF)
    assert (found.verdict, set(found.named)) == ("several", {SHELF[n] for n in named})


def test_what_is_off_the_shelf_may_make_friction_as_steady():
    """Where an effect leaves a good deal, however steady it makes friction."""
    steady = dataclasses.replace(account(0, 4.0), steadier=6.0)
    assert judge(9.0, [steady, account(1, 8.0)], SAMPLES, 1.5, SHELF).verdict == "unlisted"


def test_what_is_off_the_shelf_is_no_steadier_for_what_two_do():
    single = dataclasses.replace(account(0, 1.24), steadier=0.5)
    mended = dataclasses.replace(both(1.21), steadier=10.0)
    found = judge(4.5, [single, account(1, 4.0), mended], SAMPLES, 40.0, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))


def test_scatter_hides_what_else_would_be_told():
    """It takes nothing away from an effect that closes a large gap; the verdicts stay."""
    small = [account(0, 1.019), account(1, 1.0195)]
    mistaken = TAKEN_FOR * math.exp(-0.2)
    for nominal, accounts, moved in ((1.02, small, HIDDEN), (1.2, [account(0, 1.0)], mistaken)):
        still = judge(nominal, accounts, SAMPLES, 2.0, SHELF)
        found = judge(nominal, accounts, SAMPLES, 2.0, SHELF, hidden=SHELF)
        assert (found.verdict, found.named) == (still.verdict, still.named)
        assert found.effects["unlisted"] - still.effects["unlisted"] > 0.9 * moved
        assert sum(found.effects.values()) == pytest.approx(1.0)
        assert list(found.explanations) == list(still.explanations)
    nothing = judge(1.02, small, SAMPLES, 2.0, SHELF, hidden=SHELF)
    assert nothing.verdict == "none" and nothing.effects[SHELF[5]] > 0.002
    clear = [account(0, 1.01), account(1, 8.0)]
    assert judge(9.0, clear, SAMPLES, 2.0, SHELF, hidden=SHELF).effects[SHELF[0]] > 0.95


def test_what_leaves_a_good_part_of_a_small_gap_is_off_the_shelf():
    """It need not leave a tenth above the noise; but next to the noise nothing is called so."""
    assert judge(1.52, [account(0, 1.25)], SAMPLES, 40.0, SHELF).verdict == "unlisted"
    assert judge(1.52, [account(0, 1.02)], SAMPLES, 40.0, SHELF).named == (SHELF[0],)
    assert judge(1.05, [account(0, 1.04)], SAMPLES, 40.0, SHELF).verdict == "none"


def test_an_effect_of_another_form_than_on_the_shelf_is_still_that_effect():
    """It leaves a fifth of the excess, what only resembles the cause two fifths and more."""
    likely = judge(3.0, [account(0, 1.36), account(1, 2.6)], SAMPLES, 3.0, SHELF)
    assert (likely.verdict, likely.named) == ("effect", (SHELF[0],))
    assert judge(3.0, [account(0, 1.9), account(1, 2.6)], SAMPLES, 3.0, SHELF).verdict == "unlisted"


def test_two_that_leave_more_than_one_of_them_are_not_named_for_steadier_friction():
    alone = [account(0, 1.05), account(1, 1.95)]
    for left, verdict in ((1.065, "effect"), (1.055, "several"), (1.049, "several")):
        pair = dataclasses.replace(both(left), steadier=67.0, of_friction=(SHELF[1],))
        assert judge(2.05, [*alone, pair], SAMPLES, 40.0, SHELF).verdict == verdict


def test_a_pair_is_named_where_one_alone_leaves_a_gap():
    pair = both(1.02)
    found = judge(20.0, [account(0, 6.0), account(1, 9.0), pair], SAMPLES, 1.5, SHELF)
    assert (found.verdict, set(found.named)) == ("several", {SHELF[0], SHELF[1]})
    needless = both(1.0099)
    alone = judge(20.0, [account(0, 1.01), account(1, 9.0), needless], SAMPLES, 1.5, SHELF)
    assert (alone.verdict, alone.named) == ("effect", (SHELF[0],))


def test_a_second_effect_that_mends_the_shape_of_the_first_is_not_named():
    pair = both(3.0)
    found = judge(400.0, [account(0, 6.0), account(1, 300.0), pair], SAMPLES, 1.5, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))
    clean = both(1.0)
    found = judge(400.0, [account(0, 6.0), account(1, 300.0), clean], SAMPLES, 1.5, SHELF)
    assert found.verdict == "several"


def test_a_small_second_effect_is_named_where_it_takes_nearly_all_that_is_left():
    """Not where it takes half of it: that much a parameter more makes of another shape."""
    for left, verdict in ((1.005, "several"), (1.05, "effect")):
        pair = both(left)
        found = judge(8.0, [account(0, 1.09), account(1, 7.9), pair], SAMPLES, 1.5, SHELF)
        assert found.verdict == verdict


@pytest.mark.parametrize(
    ("nominal", "alone", "collinear", "verdict"),
    [
        (8.0, 1.09, {}, "several"),
        (8.0, 1.09, {SHELF[1]: [SHELF[0]]}, "effect"),
        (8.0, 1.8, {SHELF[1]: [SHELF[0]]}, "several"),
        (400.0, 1.4, {SHELF[1]: [SHELF[0]]}, "effect"),
        (400.0, 3.3, {SHELF[1]: [SHELF[0]]}, "several"),
    ],
)
def test_what_a_collinear_second_takes_of_little_is_a_matter_of_shape(nominal, alone, collinear, verdict):
    """Though it takes nearly all; not where much is left without it, be it a small share of the excess."""
    found = [account(0, alone), account(1, 0.9 * nominal), both(1.001)]
    assert judge(nominal, found, SAMPLES, 1.5, SHELF, collinear=collinear).verdict == verdict


@pytest.mark.parametrize(
    ("collinear", "another", "named"),
    [
        (1.001, 1.009, {SHELF[0], SHELF[1]}),
        (1.009, 1.001, {SHELF[0], SHELF[2]}),
        (1.001, 1.07, {SHELF[0]}),
    ],
    ids=["it leaves less", "it leaves more", "no other is needed"],
)
def test_where_a_second_is_needed_anyway_it_may_be_a_collinear_one(collinear, another, named):
    """As a low-pass of the force was beside a delay of the displacement, in a sealed case, for which a delay
    of the base was named, that leaves more."""
    found = [account(0, 1.25), account(1, 3.3), account(2, 3.3), both(collinear)]
    found.append(Account((SHELF[0], SHELF[2]), another, 2))
    judged = judge(3.7, found, SAMPLES, 3.9, SHELF, collinear={SHELF[1]: [SHELF[0]]})
    assert {*judged.named} == named


@pytest.mark.parametrize(
    ("two", "another", "verdict"),
    [(1.004, 1.08, "several"), (1.004, 1.04, "several"), (1.03, 1.08, "effect"), (1.004, 1.03, "effect")],
)
def test_beside_a_very_strong_effect_a_second_is_named_that_takes_all_that_is_left_and_none_else_does(
    two, another, verdict
):
    pairs = [both(two), Account((SHELF[0], SHELF[2]), another, 2)]
    found = judge(200.0, [account(0, 1.09), account(1, 199.0), *pairs], SAMPLES, 1.5, SHELF)
    assert found.verdict == verdict


@pytest.mark.parametrize(
    ("others", "same", "verdict"),
    [
        ([1.33, 1.4], (), "several"),
        ([1.17, 1.4], (), "effect"),
        ([1.13, 1.4], (SHELF[2],), "several"),
        ([], (), "effect"),
    ],
)
def test_a_second_effect_that_nothing_comes_near_is_no_matter_of_shape(others, same, verdict):
    """Others mend the shape of the first as well, are the same in these records, or were not tried."""
    found = [account(0, 1.46, 2), account(1, 29.0, 2), account(2, 29.0), both(1.126)]
    found += [Account((SHELF[0], key), left, 2) for key, left in zip(SHELF[2:4], others, strict=False)]
    assert judge(29.7, found, SAMPLES, 20.9, SHELF, {SHELF[1]: same}).verdict == verdict
    little = [account(0, 1.083, 2), account(1, 2.2, 3), both(1.012)]
    little.append(Account((SHELF[0], SHELF[2]), 1.079, 4))
    assert judge(2.23, little, SAMPLES / 2, 1.2, SHELF).verdict == "effect"


def test_a_second_effect_counts_by_its_share_of_what_the_first_leaves():
    """And not by its share of a gap that the first has closed but for the noise."""
    pair = both(1.03)
    found = judge(150.0, [account(0, 1.35), account(1, 140.0), pair], SAMPLES, 3.0, SHELF)
    assert (found.verdict, set(found.named)) == ("several", {SHELF[0], SHELF[1]})
    half = both(1.18)
    found = judge(150.0, [account(0, 1.35), account(1, 140.0), half], SAMPLES, 3.0, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))


@pytest.mark.parametrize(
    ("nominal", "alone", "left", "verdict"),
    [
        (2.6, 1.11, 1.03, "effect"),
        (2.6, 1.11, 1.005, "several"),
        (74.0, 2.9, 1.7, "several"),
        (74.0, 1.9, 1.4, "effect"),
    ],
)
def test_shapes_may_lack_more_of_a_small_gap_than_of_a_large_one(nominal, alone, left, verdict):
    found = judge(nominal, [account(0, alone), account(1, nominal - 0.1), both(left)], SAMPLES, 20.0, SHELF)
    assert found.verdict == verdict


def test_two_others_do_not_take_the_place_of_the_effect_that_nearly_suffices():
    """A low-pass and a resonance together have the shape of many a delay; with the delay they are heard."""
    alone = [account(0, 1.05), account(1, 1.2), account(2, 4.0)]
    others = Account((SHELF[1], SHELF[2]), 1.005, 4)
    found = judge(4.8, [*alone, others], SAMPLES, 20.0, SHELF)
    assert (found.verdict, found.named) == ("effect", (SHELF[0],))
    with_it = Account((SHELF[0], SHELF[2]), 1.005, 2)
    assert judge(4.8, [*alone, with_it], SAMPLES, 3.0, SHELF).verdict == "several"


def test_aliases_are_left_open_beside_another_effect():
    """Named first are two that act together, then what may act in the place of one."""
    singles = [account(0, 6.0), account(1, 9.0), account(2, 9.1)]
    pairs = [both(1.02), Account((SHELF[2], SHELF[0]), 1.06, 2)]
    aliases = {SHELF[1]: [SHELF[2]], SHELF[2]: [SHELF[1]]}
    found = judge(20.0, [*singles, *pairs], SAMPLES, 1.5, SHELF, aliases)
    assert found.verdict == "several" and set(found.named) == {*SHELF[:3]}
    assert SHELF[0] in found.named[:2]
    place = {SHELF[1]: SHELF[2], SHELF[2]: SHELF[1]}[found.named[2]]
    assert alternatives(found.explanations, found.named[:2]) == {found.named[2]: place}
    assert found.effects[SHELF[1]] == pytest.approx(found.effects[SHELF[2]], rel=0.01)
    told = judge(20.0, [*singles, *pairs], SAMPLES, 1.5, SHELF)
    assert set(told.named) == {SHELF[0], SHELF[1]}
    assert not alternatives(told.explanations, told.named)


@pytest.mark.parametrize(("nominal", "alone", "left"), [(254.0, 21.1, 3.16), (33.0, 4.4, 1.78)])
def test_two_effects_are_named_although_neither_has_quite_the_shape_on_the_shelf(nominal, alone, left):
    """They leave two or three times the noise, the first alone a tenth of the excess."""
    found = judge(nominal, [account(0, alone), account(1, nominal - 1), both(left)], SAMPLES, 40.0, SHELF)
    assert found.verdict == "several" and set(found.named) == {SHELF[0], SHELF[1]}
    little = judge(
        nominal, [account(0, alone), account(1, nominal - 1), both(0.6 * alone)], SAMPLES, 40.0, SHELF
    )
    assert (little.verdict, little.named) == ("effect", (SHELF[0],))


@given(st.integers(1, 5), st.integers(2, 8), st.floats(2.0, 1e4))
def test_what_one_run_has_of_its_own_costs_less_than_what_all_share(shared, runs, pieces):
    def price(parameters: int, of_one_run: float) -> float:
        return Account((SHELF[0],), 1.0, parameters, of_one_run, runs).price(pieces)

    assert price(shared, 0.0) == pytest.approx(0.5 * shared * math.log(pieces))
    assert price(shared, 0.0) <= price(shared, 0.5) <= price(shared, 1.0) < price(shared + 1, 0.0)


@given(st.integers(2, 5), st.floats(2.0, 1e4), st.floats(0.0, 1e3), st.floats(0.0, 1e3))
def test_a_shape_costs_what_the_records_say_of_it(parameters, pieces, told, other):
    def price(*shapes: float) -> float:
        return Account((SHELF[0],), 1.0, parameters, shapes=shapes).price(pieces)

    assert price(0.0) == pytest.approx(0.5 * (parameters - 1) * math.log(pieces))
    assert price(0.0, math.inf) == price(math.inf, 0.0) == pytest.approx(price(0.0))
    assert price(min(told, other)) <= price(max(told, other)) <= price(math.inf) == price()
    assert price((math.sqrt(pieces) - 1) / pieces) == pytest.approx(
        0.5 * (parameters - 0.5) * math.log(pieces)
    )


def test_what_suffices_may_still_leave_something_to_a_second_effect():
    assert suffices(4.0, 1.09) and not leaves_nothing(4.0, 1.09)
    assert leaves_nothing(4.0, 1.02) and leaves_nothing(400.0, 1.15)
    assert not suffices(4.0, 1.2) and not leaves_nothing(400.0, 3.0)


def test_a_second_effect_is_sought_where_a_first_takes_something_away():
    assert hints(400.0, 300.0) and hints(1.2, 1.1)
    assert not hints(400.0, 395.0) and not hints(1.2, 1.199)
    assert not hints(1.0, 1.0) and not hints(0.9, 0.95)


def test_more_parameters_cost_more():
    cheap = judge(1.05, [account(0, 1.0, 1), account(1, 1.0, 4)], SAMPLES, 2.0, SHELF)
    assert cheap.effects[SHELF[0]] > 100 * cheap.effects[SHELF[1]]


@given(
    st.floats(0.8, 500.0),
    st.lists(st.floats(0.8, 500.0), min_size=1, max_size=6),
    st.floats(0.3, 200.0),
    st.floats(1e3, 1e6),
)
def test_probabilities_add_up_and_are_never_certain(nominal, misfits, inflation, samples):
    accounts = [account(n, misfit) for n, misfit in enumerate(misfits)]
    found = judge(nominal, accounts, samples, inflation, SHELF)
    for table in (found.explanations, found.effects):
        assert sum(table.values()) == pytest.approx(1.0, abs=1e-9)
        assert set(table) == {"none", "unlisted", *SHELF}
        assert all(0 < p < 1 for p in table.values())
    assert found.verdict in ("none", "effect", "ambiguous", "unlisted")


def test_correlated_and_biased_residuals_are_fewer_pieces_of_evidence():
    clean = pieces_of_evidence(1.0, SAMPLES, 1.0)
    assert clean == pytest.approx(SAMPLES / LEAST_INFLATION)
    assert pieces_of_evidence(1.0, SAMPLES, 20.0) == pytest.approx(SAMPLES / 20)
    assert pieces_of_evidence(1.3, SAMPLES, 2.0) < clean / 50
    assert math.isfinite(pieces_of_evidence(1e6, SAMPLES, 2.0))


def test_effects_that_no_record_tells_apart_are_answered_together():
    """However clearly what is stated of the rig speaks for one of them."""
    classes = {(SHELF[0],): (SHELF[3], SHELF[4])}
    found = judge(9.0, [account(0, 1.01), account(3, 5.0)], SAMPLES, 1.5, SHELF, classes=classes)
    alone = judge(9.0, [account(0, 1.01), account(3, 5.0)], SAMPLES, 1.5, SHELF)
    assert alone.verdict == "effect" and alone.same == ()
    assert found.verdict == "ambiguous" and found.named == (SHELF[0], SHELF[3], SHELF[4])
    assert found.same == (found.named,)
    assert found.effects[SHELF[0]] <= 0.6 and min(found.effects[key] for key in found.named) > 0.1
    assert sum(found.effects.values()) == pytest.approx(1.0)
    named = sum(found.effects[key] for key in found.named)
    assert named == pytest.approx(sum(alone.effects[key] for key in found.named))
    none = judge(1.0, [account(0, 0.9998)], SAMPLES, 1.0, SHELF, classes=classes)
    assert none.verdict == "none" and none.named == none.same == ()


def test_next_to_nothing_of_a_large_gap_is_no_evidence_for_a_second_effect():
    """A thousandth of it says that the first has not quite the shelf's shape; a hundredth, that two act."""
    for alone, verdict in ((1.28, "effect"), (3.1, "several")):
        two = [account(0, alone), account(1, 200.0), both(1.01)]
        assert judge(212.0, two, SAMPLES, 1.5, SHELF).verdict == verdict


def test_what_leaves_most_of_the_gap_is_not_named_for_steadier_friction():
    """An effect off the shelf, which leaves less, would make friction no less steady."""
    for left, verdict in ((2.04, "unlisted"), (1.05, "effect")):
        steadier = dataclasses.replace(account(0, left), steadier=27.0)
        assert judge(2.5, [steadier, account(1, 2.4)], SAMPLES, 1.5, SHELF).verdict == verdict


def test_in_a_pair_too_an_effect_stands_for_its_class():
    """As it is where the other acts beside it, whatever it is alone."""
    classes = {(SHELF[0], SHELF[1]): (SHELF[3],), (SHELF[0],): (SHELF[4],), (SHELF[1],): (SHELF[4],)}
    two = [account(0, 20.0), account(1, 30.0), Account((SHELF[1], SHELF[0]), 1.0, 2)]
    found = judge(50.0, two, SAMPLES, 1.5, SHELF, classes=classes)
    assert found.verdict == "several" and found.named == (SHELF[1], SHELF[0], SHELF[3])
    assert found.taken == (SHELF[1], SHELF[0]) and found.same == ((SHELF[0], SHELF[3]),)
    assert 0.1 < found.effects[SHELF[3]] < found.effects[SHELF[0]] < found.effects[SHELF[1]]
    assert sum(found.effects.values()) == pytest.approx(1.0)


def test_a_class_is_not_outweighed_for_being_shared():
    """Three names of one cause count as that one against "unlisted"."""
    classes = {(SHELF[0],): (SHELF[3], SHELF[4])}
    close = [account(0, 1.8), account(1, 6.0)]
    assert judge(9.0, close, SAMPLES, 1.5, SHELF).verdict == "effect"
    assert judge(9.0, close, SAMPLES, 1.5, SHELF, classes=classes).verdict == "ambiguous"


def test_an_explanation_that_leaves_more_than_none_earns_nothing_by_steadier_friction():
    """Its search ended elsewhere: the nominal model would have steadier friction there as well."""
    elsewhere = dataclasses.replace(account(0, 1.14), steadier=12.0)
    better = dataclasses.replace(account(0, 1.085), steadier=12.0)
    assert judge(1.09, [elsewhere, account(1, 1.084)], SAMPLES, 50.0, SHELF).verdict == "none"
    assert judge(1.09, [better, account(1, 1.084)], SAMPLES, 50.0, SHELF).named == (SHELF[0],)


def test_what_one_effect_leaves_within_what_the_noise_is_known_to_needs_no_second():
    """Even where the two leave less than the noise is said to be, which is what they are measured by then."""
    for alone, verdict in ((0.943, "effect"), (0.99, "several")):
        found = [account(0, alone), account(1, 1.6), both(0.913)]
        assert judge(1.667, found, SAMPLES, 1.7, SHELF).verdict == verdict
