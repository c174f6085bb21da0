"""Two effects that friction which may wander would hide."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.ground import Ground
from fitting.diagnosis.noise.repeatability import wanders
from fitting.diagnosis.which import pairs
from fitting.diagnosis.which.explanation import Explanation, best_of
from fitting.diagnosis.which.pairs import with_still_friction
from fitting.diagnosis.which.survey import Survey, nominal_on, survey
from fitting.progress import Silent
from jaxstick.effects.friction_drift import FrictionDrift
from jaxstick.effects.periodic_track import PeriodicTrack
from tests.fitting.diagnosis.grounded import grounded

PAIR = {"friction_drift": FrictionDrift(0.08), "periodic_track": PeriodicTrack(0.02, -0.02, 3e-3)}


@pytest.fixture(scope="module")
def surveyed() -> tuple[Model, Ground, Survey]:
    """A drift and a ripple of 3 %: a level for every segment takes the drift and part of the ripple over."""
    _, model, base = grounded(dict(PAIR), 12)
    nominal = nominal_on(model, base.bench, base.point)
    return model, base, survey(model, base.bench, nominal, base.begins, Silent())


@pytest.fixture(scope="module")
def still(surveyed) -> list[Explanation]:
    """What is found with still friction where the best single effect leads."""
    model, base, seen = surveyed
    return with_still_friction(model, base.bench, seen.nominal, seen.found[0], seen.screen.shapes, Silent())


def test_what_wandering_hides_is_found_with_still_friction(surveyed, still):
    model, _, seen = surveyed
    leader = seen.found[0]
    assert wanders(seen.nominal) and wanders(leader.refit)
    best = min(best_of(still), key=lambda e: e.refit.misfit)
    assert {*best.keys} == {*PAIR} and not wanders(best.refit)
    assert best.refit.misfit < min(1.1, leader.refit.misfit)
    truth = {"friction_drift.rate": 0.08, "periodic_track.wavelength": 3e-3, "periodic_track.cosine": 0.02}
    assert model.values(best.refit.point.coordinates, tuple(truth)) == pytest.approx(truth, rel=0.2)


def test_pairs_are_sought_beside_the_leader_kept_still(surveyed, monkeypatch):
    """Friction that drifts may be all that the best effect leaves, and be taken for wandering: where that
    effect is not among those tried with still friction, it is there all the same."""
    model, base, seen = surveyed
    leader = next(e for e in seen.found if e.keys == ("periodic_track",))
    made = pairs.contest
    based: list[tuple[str, ...]] = []

    def others(model: Any, bench: Any, at: Any, promises: Any, *given: Any, **named: Any) -> Any:
        based.append(model.free_effects(at.free))
        promises = [p for p in promises if p.key not in PAIR or based[-1]]
        return made(model, bench, at, promises, *given, **named)

    monkeypatch.setattr(pairs, "contest", others)
    found = with_still_friction(model, base.bench, seen.nominal, leader, seen.screen.shapes, Silent())
    assert based == [(), ("periodic_track",)]
    best = min(found, key=lambda e: e.refit.misfit)
    assert {*best.keys} == {*PAIR} and not wanders(best.refit)


def test_beside_two_effects_no_third_is_sought(surveyed, still, monkeypatch):
    """What keeps another time beside the best effect leads as a pair: in a sealed case the verdict then
    rested on three effects, of which no more than two are ever named."""
    model, base, seen = surveyed
    leader = next(e for e in still if {*e.keys} == {*PAIR})
    monkeypatch.setattr(pairs, "wanders", lambda fit: True)
    more = with_still_friction(model, base.bench, seen.nominal, leader, seen.screen.shapes, Silent())
    assert {len(e.keys) for e in more} == {1, 2}


class Search(NamedTuple):
    """A search for pairs among explanations that are only names and misfits."""

    found: list[Any]
    led: list[tuple[str, ...]]
    outright: list[tuple[tuple[str, ...], list[str]]]


def explained(misfit: float, *keys: str) -> Any:
    return SimpleNamespace(keys=keys, refit=SimpleNamespace(misfit=misfit, keys=keys))


def sought(
    monkeypatch: pytest.MonkeyPatch, left: dict[str, float], most: dict[str, dict[str, float]], tries: float
) -> Search:
    """What is found where the best single effects leave `left`, beside each the two leave what `most`
    says, and `tries` is left by what is tried outright: all but "first" and "signed" have one sign."""
    led, outright = list[tuple[str, ...]](), list[tuple[tuple[str, ...], list[str]]]()

    def contest(model: Any, bench: Any, base: Any, promises: Any, *rest: Any) -> list[Any]:
        led.append(base.keys)
        return [explained(misfit, *base.keys, key) for key, misfit in most[base.keys[0]].items()]

    def tried(model: Any, bench: Any, base: Any, promises: Any, *rest: Any) -> list[Any]:
        outright.append((base.keys, [promise.key for promise in promises]))
        return [explained(tries, *base.keys, "outright")]

    promises = [SimpleNamespace(key=key) for key in ("first", "second", "signed", "grows")]
    seen = SimpleNamespace(ranked=[], promises=promises, shapes=[])
    monkeypatch.setattr(pairs, "has_one_sign", lambda model, promise: promise.key not in ("first", "signed"))
    monkeypatch.setattr(pairs, "contest", contest)
    monkeypatch.setattr(pairs, "outright", tried)
    monkeypatch.setattr(pairs, "screen", lambda *_, **__: seen)
    monkeypatch.setattr(pairs, "freed", lambda m, b, e, n: sorted(e, key=lambda each: each.refit.misfit))
    monkeypatch.setattr(pairs, "in_place_of_either", lambda m, b, found, *_: found)
    singles = [explained(misfit, key) for key, misfit in left.items()]
    nothing: Any = None
    around: Any = seen
    found = pairs.pairs_beside(nothing, nothing, singles, around, 1.0, Silent())
    return Search(found, led, outright)


def test_an_effect_of_the_best_pair_leads_a_search_of_its_own(monkeypatch: pytest.MonkeyPatch):
    """The third of the single effects belongs to the best pair, and its best partner is no other's."""
    left = {"first": 3.0, "second": 3.5, "third": 4.0}
    most = {"first": {"third": 1.5}, "second": {"fourth": 2.0}, "third": {"fifth": 1.01}}
    search = sought(monkeypatch, left, most, 9.0)
    assert search.led == [("first",), ("second",), ("third",)]
    assert search.found[0].keys == ("third", "fifth")


def test_what_has_one_sign_is_tried_outright_beside_the_best_where_two_do_not_suffice(
    monkeypatch: pytest.MonkeyPatch,
):
    left = {"first": 3.0, "second": 9.0}
    search = sought(monkeypatch, left, {"first": {"second": 1.5}, "second": {"first": 1.5}}, 1.0)
    assert search.outright == [(("first",), ["grows"])]
    assert search.found[0].keys == ("first", "outright")
    search = sought(monkeypatch, left, {"first": {"second": 1.05}, "second": {"first": 1.05}}, 1.0)
    assert search.outright == []


@pytest.mark.parametrize("given_way", [True, False])
def test_what_stayed_is_looked_at_again_where_the_other_has_given_way(
    monkeypatch: pytest.MonkeyPatch, given_way: bool
):
    """Beside friction that weakens with slip a wrong stiffness may explain more than the gain that acts, and
    less beside the memory of friction that acts with it (a sealed case)."""
    seen: list[tuple[tuple[str, ...], str, int]] = []
    left = {("weakening", "stiffness"): 1.4, ("weakening", "gain"): 1.5, ("memory", "gain"): 1.0}
    left |= {("memory", "stiffness"): 1.2 if given_way else 1.6}

    def second_look(m: Any, b: Any, found: Any, key: str, others: int, *rest: Any) -> list[Any]:
        first, second = found[0].keys
        seen.append((found[0].keys, key, others))
        keys = ("memory", second) if key == "weakening" else (first, "gain")
        return [explained(left[keys], *keys)]

    monkeypatch.setattr(pairs, "second_look", second_look)
    monkeypatch.setattr(pairs, "freed", lambda m, b, e, n: sorted(e, key=lambda each: each.refit.misfit))
    nothing: Any = None
    begun = [explained(1.4, "weakening", "stiffness")]
    found = pairs.in_place_of_either(nothing, nothing, begun, 3, nothing, Silent())
    usual = [(("weakening", "stiffness"), "weakening", 3), (("weakening", "stiffness"), "stiffness", 3)]
    again = [(("memory", "stiffness"), "stiffness", 0)]
    assert seen == usual + (again if given_way else [])
    assert found[0].keys == (("memory", "gain") if given_way else ("weakening", "stiffness"))
