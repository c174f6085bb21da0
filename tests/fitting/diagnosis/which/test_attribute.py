"""What an explanation is judged by."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.accounts import Account, within_scatter
from fitting.diagnosis.findings import Yardstick
from fitting.diagnosis.lanes.model import Shelf
from fitting.diagnosis.which import attribute as attributes
from fitting.diagnosis.which.attribute import (
    PROMISING,
    Attribution,
    account,
    attribute,
    traces_left,
    worth_a_second,
)

FLOOR = 1.1


def counted(misfit: float, *keys: str) -> Account:
    """The account of an explanation by these effects, which leaves this misfit, in units of the floor. Each
    has a strength, number 0, and a shape, number 7."""
    effects: dict[str, Any] = {
        key: SimpleNamespace(card=SimpleNamespace(family="friction"), changes=False) for key in keys
    }
    shelf = Shelf(effects, {}, {key: ("shape",) for key in keys}, {})
    model: Any = SimpleNamespace(
        of=lambda _: np.array([0, 7]),
        index=lambda *names: np.full(len(names), 7),
        by_run=np.zeros(0, int),
        shelf=shelf,
    )
    run = np.array([0, 0, 1])
    bench: Any = SimpleNamespace(run=run, wanders=False, dof=lambda: np.full(3, 50.0))
    refit = SimpleNamespace(told={3: math.inf, 0: 900.0, 7: 30.0})
    found: Any = SimpleNamespace(keys=keys, refit=refit)
    return account(model, bench, None, found, misfit / FLOOR)


def test_what_the_records_say_of_a_shape_is_counted_by_the_degree_of_freedom():
    made = counted(1.2, "one")
    assert made.parameters == 2 and made.shapes == (0.2,)


@pytest.mark.parametrize(
    ("strengths", "credited"),
    [((0.0,), 0.0), ((1e-5,), 0.0), ((0.2,), 12.6), ((-0.2,), 12.6), ((0.0, 0.0), 0.0), ((0.3, 0.0), 12.6)],
)
def test_an_effect_that_does_nothing_makes_friction_no_steadier(monkeypatch, strengths, credited):
    """A lag of nought, for which the search has found other starts than for the nominal model."""
    monkeypatch.setattr(attributes, "steadier", lambda *_: 12.6)
    keys = tuple(f"effect {number}" for number in range(len(strengths)))
    effects: dict[str, Any] = {
        key: SimpleNamespace(card=SimpleNamespace(family="friction"), changes=False) for key in keys
    }
    shelf = Shelf(effects, {key: (key,) for key in keys}, {key: () for key in keys}, {})
    model: Any = SimpleNamespace(
        of=lambda key: np.array([keys.index(key)]),
        index=lambda *names: np.array([keys.index(name) for name in names], int),
        by_run=np.zeros(0, int),
        shelf=shelf,
    )
    bench: Any = SimpleNamespace(run=np.array([0, 0, 1]), wanders=True, dof=lambda: np.full(3, 50.0))
    point = SimpleNamespace(coordinates=np.array(strengths))
    found: Any = SimpleNamespace(keys=keys, refit=SimpleNamespace(point=point, levels=None, told={}))
    nominal: Any = None
    assert account(model, bench, nominal, found, 1.0).steadier == 0.0
    nominal = "levels"
    assert account(model, bench, nominal, found, 1.0).steadier == credited


@pytest.mark.parametrize(
    ("one", "two", "counts"), [(1.2, 0.9, 1.0), (1.2, 1.1, 1.1), (0.8, 0.7, 0.8), (0.8, 0.9, 0.9)]
)
def test_a_second_effect_neither_earns_nor_pays_for_less_than_what_was_weighed_by(one, two, counts):
    """What does not repeat itself leaves 1, or less where it is overrated."""
    alone, other, both = within_scatter(
        [Account(("one",), one, 1), Account(("other",), 3.0, 1), Account(("one", "other"), two, 2)]
    )
    assert (alone.misfit, other.misfit, both.misfit) == (one, 3.0, counts)


def test_what_is_found_beside_wandering_takes_the_place_of_a_worse_fit_of_the_same_effect(monkeypatch):
    """Beside pairs, too; and a pair in the other order that of one that is fitted worse."""

    def leaving(misfit: float, *keys: str) -> Any:
        return SimpleNamespace(keys=keys, refit=SimpleNamespace(misfit=misfit))

    nominal = SimpleNamespace(misfit=9.0)
    quiet = SimpleNamespace(promises=[SimpleNamespace(standing=0.0)])
    found = (leaving(3.0, "one"), leaving(4.0, "drift"))
    seen: Any = SimpleNamespace(nominal=nominal, screen=SimpleNamespace(shapes=()), found=found, floor=1.0)
    replaced = {
        "wanders": False,
        "in_step": [leaving(2.0, "drift")],
        "borrowed": nominal,
        "none_above": [leaving(2.0, "drift"), leaving(3.0, "one")],
        "floor_of": 1.0,
        "screen": quiet,
        "pairs_beside": [leaving(1.5, "one", "drift")],
        "each_alone": [],
        "other_way_round": [leaving(1.2, "one", "drift")],
        "on_the_other_side": [],
        "_inflation": 1.0,
    }
    for name, answer in replaced.items():
        monkeypatch.setattr(attributes, name, lambda *_, answer=answer, **__: answer)
    monkeypatch.setattr(attributes, "_weighed", lambda model, bench, fit, explanations, *_: explanations)
    nothing: Any = None
    weighed: Any = attribute(nothing, nothing, seen, nothing)
    assert {e.keys: e.refit.misfit for e in weighed} == {
        ("one",): 3.0,
        ("drift",): 2.0,
        ("one", "drift"): 1.2,
    }


def test_a_lane_that_only_the_next_best_finds_is_found_in_the_nominal_model_too(monkeypatch):
    """In a sealed case in which nothing acted it made a gain of the base that one effect of the shelf."""

    def leaving(misfit: float, *keys: str) -> Any:
        return SimpleNamespace(keys=keys, refit=SimpleNamespace(misfit=misfit))

    lost: Any = SimpleNamespace(misfit=1.05)
    found: Any = [leaving(1.048, "track"), leaving(1.049, "gain")]

    def borrowed(model: Any, bench: Any, fit: Any, other: Any) -> Any:
        return SimpleNamespace(misfit=min(fit.misfit, other.misfit + 1e-4))

    def none_above(model: Any, bench: Any, fit: Any, found: Any) -> Any:
        return [leaving(min(e.refit.misfit, fit.misfit), *e.keys) for e in found]

    monkeypatch.setattr(attributes, "borrowed", borrowed)
    monkeypatch.setattr(attributes, "none_above", none_above)
    for reached, expected in ((1.007, 1.0071), (1.0485, 1.05)):
        level = sorted([found[0], leaving(reached, "gain")], key=lambda e: e.refit.misfit)
        monkeypatch.setattr(attributes, "brought_level", lambda model, bench, found, level=level: level)
        nothing: Any = None
        nominal, others = attributes._level(nothing, nothing, lost, found)
        assert nominal.misfit == pytest.approx(expected)
        assert others[0].refit.misfit == pytest.approx(min(reached, 1.048))
        assert max(e.refit.misfit for e in others) <= nominal.misfit


@pytest.mark.parametrize(
    ("left", "sought"),
    [(1.2, True), (1.07, False), (8.95, False)],
    ids=["leaves more than noise", "leaves noise", "leaves nearly all"],
)
def test_pairs_are_sought_anew_where_all_leave_more_once_weighed_anew(monkeypatch, left, sought):
    """As beside a hum, which does not repeat itself from cycle to cycle, in a sealed case."""

    def leaving(misfit: float, *keys: str) -> Any:
        return SimpleNamespace(keys=keys, refit=SimpleNamespace(misfit=2.0 * misfit))

    known = leaving(left, "hum", "table"), leaving(left + 0.1, "hum"), leaving(9.5, "gain")
    nominal: Any = SimpleNamespace(misfit=18.0)
    first: Any = "first"
    around: Any = "around"
    asked: list[Any] = []

    def pairs_beside(model: Any, bench: Any, singles: Any, *others: Any) -> Any:
        asked.append([e.keys for e in singles])
        return [leaving(1.15, "hum", "table"), leaving(1.3, "hum", "delay")]

    def on_the_other_side(model: Any, bench: Any, one: Any, around: Any, progress: Any) -> Any:
        asked.append((one.keys, around))
        return [leaving(0.9, "hum", "hysteresis")]

    replaced = {
        "screen": lambda *_: around,
        "pairs_beside": pairs_beside,
        "other_way_round": lambda *_: [],
        "on_the_other_side": on_the_other_side,
        "each_alone": lambda *_: [leaving(8.0, "hysteresis")],
        "_level": lambda model, bench, nominal, found: (nominal, found),
        "_inflation": lambda *_: 1.0,
        "_weighed": lambda model, bench, nominal, found, *_: found,
    }
    for name, answer in replaced.items():
        monkeypatch.setattr(attributes, name, answer)
    judgement: Any = None
    found = Attribution(nominal, known, first, judgement, Yardstick(18.0, 2.0, 1e4, 1.0))
    nothing: Any = None
    anew: Any = attributes.with_pairs_anew(nothing, nothing, found, nothing)
    if not sought:
        assert anew is found and not asked
        return
    assert asked == [[("hum",), ("gain",)], (("hum",), "around")]
    assert {e.keys: e.refit.misfit / 2 for e in anew} == {
        ("hum", "hysteresis"): 0.9,
        ("hum", "table"): 1.15,
        ("hum", "delay"): 1.3,
        ("hum",): left + 0.1,
        ("hysteresis",): 8.0,
        ("gain",): 9.5,
    }


@pytest.mark.parametrize(
    ("two", "one", "floor", "asks"),
    [(4.7, 8.2, 1.0, True), (7.5, 8.2, 1.0, False), (1.05, 8.2, 1.0, False), (1.3, 8.2, 1.28, False)],
)
def test_a_contact_is_asked_for_where_two_effects_leave_less_than_one_and_yet_a_good_deal(
    two, one, floor, asks
):
    explanations = [
        SimpleNamespace(keys=keys, refit=SimpleNamespace(misfit=misfit))
        for keys, misfit in ((("one", "other"), two), (("one",), one), (("other",), 100.0))
    ]
    found: Any = SimpleNamespace(explanations=explanations, floor=floor)
    asked: Any = Attribution.asks_for_a_contact
    assert asked.fget(found) is asks
    found.explanations = explanations[1:]
    assert not asked.fget(found)


def test_what_is_fitted_once_more_holds_the_best_alone_and_the_effects_of_the_very_best():
    """A pair is judged by what its effects leave alone, and one effect by what others do in its place,
    however many other pairs come before these."""
    pairs = [("one", f"other {n}") for n in range(9)]
    singles = ["some", *(f"another {n}" for n in range(4)), "one", "other 3"]
    explanations = [SimpleNamespace(keys=keys) for keys in (*pairs, *((key,) for key in singles))]
    leading: Any = Attribution.leading
    found = [e.keys for e in leading.fget(SimpleNamespace(explanations=explanations))]
    assert found == [*pairs[:8], *((key,) for key in singles[:4]), ("one",)]


@pytest.mark.parametrize(
    ("score", "inflation", "worth"), [(50.0, 1.0, True), (20.0, 0.5, False), (50.0, 3.0, False)]
)
def test_a_second_effect_is_worth_a_search_for_a_good_part_of_what_one_leaves(score, inflation, worth):
    """1000 degrees of freedom of which one effect leaves 0.7: noise that is less than is stated."""
    promise = SimpleNamespace(score=score, standing=score / inflation)
    around: Any = SimpleNamespace(promises=[SimpleNamespace(score=1.0, standing=1.0), promise])
    bench: Any = SimpleNamespace(dof=lambda: np.full(10, 100.0))
    alone: Any = SimpleNamespace(misfit=0.7)
    assert worth_a_second(bench, alone, around) is worth
    assert promise.standing > PROMISING or not worth


@pytest.mark.parametrize(
    ("floor", "scatters", "freed", "inflation"),
    [
        (1.0, False, False, 3.0),
        (1.25, False, False, 20.8),
        (1.25, True, False, 100.0),
        (1.0, True, True, 100 / 3),
    ],
)
def test_scores_vary_by_what_scatters_in_step_for_a_lane(floor, scatters, freed, inflation):
    """Lanes of 100 residuals: a fifth of what these are, or all, is one piece of evidence for each."""
    lanes, whitener = np.zeros(10), np.eye(2) if freed else None
    bench: Any = SimpleNamespace(
        dof=lambda: np.full(10, 100.0), lanes=lanes, whitener=whitener, scatters=scatters
    )
    seen: Any = SimpleNamespace(inflation=3.0)
    assert attributes._inflation(bench, seen, floor) == pytest.approx(inflation)


def test_what_cannot_be_seen_leaves_no_trace_that_others_share():
    """A gain of a base that stands still is no alias of a wrong stiffness there, but stays known."""
    traces = dict.fromkeys(("base_gain", "stiffness_error"), ("scale",))
    usual = [
        SimpleNamespace(key="base_gain", can_be_seen=False),
        SimpleNamespace(key="stiffness_error", can_be_seen=True),
    ]
    model: Any = SimpleNamespace(shelf=SimpleNamespace(traces=traces))
    seen: Any = SimpleNamespace(usual=usual)
    assert traces_left(model, seen) == {"base_gain": (), "stiffness_error": ("scale",)}
