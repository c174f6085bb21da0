"""What explains the records as well as what was found first, or only in company so far."""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.ground import Ground
from fitting.diagnosis.refits.refit import refit
from fitting.diagnosis.refits.release import released
from fitting.diagnosis.which import survey as surveying
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.pairs import each_alone
from fitting.diagnosis.which.screen import screen
from fitting.diagnosis.which.survey import collinear, nominal_on, second_look, survey
from fitting.progress import Silent
from jaxstick.effects.displacement_gain import DisplacementGain
from tests.fitting.diagnosis.grounded import grounded, with_effect

KEY, MATE, IDLE = "stiffness_error", "displacement_gain", "constant_force"


@pytest.fixture(scope="module")
def enlarged() -> tuple[Model, Ground]:
    """Two noisy runs whose displacement is read 6 % too large, and their ground."""
    _, model, base = grounded({MATE: DisplacementGain(0.06)}, 8)
    return model, base


def test_an_effect_with_the_same_trace_is_found_where_the_other_stands(enlarged):
    """Springs and mass that are off do what a gain does; in their place the gain leaves no more than they.
    How large it is depends on mass and springs within their tolerance."""
    model, base = enlarged
    (nominal,) = refit(model, base.bench, [base.point], [model.nuisances()])
    promise = next(p for p in screen(model, base.bench, nominal, shapes=[]).promises if p.key == KEY)
    other = with_effect(model, base, nominal, KEY)
    first = Explanation((KEY,), promise, released(model, base.bench, other))
    assert nominal.misfit > 100 and first.refit.misfit < 1.2
    found = {e.keys: e for e in second_look(model, base.bench, [first], KEY, 0, [], Silent())}
    assert (MATE,) in found and (KEY,) not in found
    gain = found[MATE,].refit
    assert gain.misfit < 1.2
    value = model.values(gain.point.coordinates, [f"{MATE}.gain"])[f"{MATE}.gain"]
    assert value == pytest.approx(0.06, abs=0.02)


def test_an_effect_that_was_only_found_beside_another_is_found_alone(enlarged):
    """The gain has come out beside a force that is not there; by itself the search for it stayed at null."""
    model, base = enlarged
    (nominal,) = refit(model, base.bench, [base.point], [model.nuisances()])
    seen = screen(model, base.bench, nominal, shapes=[])
    promises = {promise.key: promise for promise in seen.promises}
    right = released(model, base.bench, with_effect(model, base, nominal, MATE))
    company = model.sharing.together((MATE, IDLE))
    point = dataclasses.replace(right.point, keys=company)
    (both,) = refit(model, base.bench, [point], [np.concatenate([right.free, model.of(IDLE)])])
    stuck = dataclasses.replace(nominal, free=right.free)
    found = [Explanation((key,), promises[key], stuck) for key in (MATE, IDLE)]
    pairs = [Explanation((MATE, IDLE), promises[IDLE], both)]
    alone = {e.keys: e.refit for e in each_alone(model, base.bench, found, pairs, seen)}
    assert alone[MATE,].misfit == pytest.approx(right.misfit, rel=0.02)
    assert set(model.of(IDLE)).isdisjoint(alone[MATE,].free)
    assert (IDLE,) not in alone or alone[IDLE,].misfit > 10 * right.misfit


def test_what_is_known_from_the_same_lanes_is_not_lost(enlarged, monkeypatch):
    """Where the search stays at null, what it had found before leads on."""
    model, base = enlarged
    nominal = nominal_on(model, base.bench, base.point)
    right = released(model, base.bench, with_effect(model, base, nominal, MATE))
    (promise,) = (p for p in screen(model, base.bench, nominal, shapes=[]).promises if p.key == MATE)
    stuck = Explanation((MATE,), promise, dataclasses.replace(nominal, free=right.free))
    monkeypatch.setattr(surveying, "contest", lambda *_: [stuck])
    monkeypatch.setattr(surveying, "outright", lambda *_: [])
    lost, kept = (
        survey(model, base.bench, nominal, base.begins, Silent(), known)
        for known in ((), [Explanation((MATE,), promise, right)])
    )
    assert lost.least == pytest.approx(nominal.misfit, rel=0.05) and not lost.suffices
    assert kept.least == pytest.approx(right.misfit, rel=0.05) and kept.suffices


def test_a_pair_that_is_known_does_not_lose_the_best_single_effect(enlarged, monkeypatch):
    """Of what leads as a pair the better of its effects leaves far more alone; it is known all the same, and
    others are sought beside it."""
    model, base = enlarged
    nominal = nominal_on(model, base.bench, base.point)
    right = released(model, base.bench, with_effect(model, base, nominal, MATE))
    (promise,) = (p for p in screen(model, base.bench, nominal, shapes=[]).promises if p.key == MATE)
    left = {(MATE, IDLE): 1.0, (KEY, IDLE): 1.6, (MATE,): 3.0, (KEY,): 4.0, (IDLE,): 5.0}
    known = [Explanation(k, promise, dataclasses.replace(right, misfit=m)) for k, m in left.items()]
    again: list[tuple[str, ...]] = []

    def fitted_again(_model: Model, _bench: Bench, some: Sequence[Explanation]) -> list[Explanation]:
        again.extend(e.keys for e in some)
        return [*some]

    stuck = Explanation((MATE,), promise, dataclasses.replace(nominal, free=right.free))
    monkeypatch.setattr(surveying, "contest", lambda *_: [stuck])
    monkeypatch.setattr(surveying, "second_look", lambda *_: [])
    monkeypatch.setattr(surveying, "freed", lambda _model, _bench, explanations: [*explanations])
    monkeypatch.setattr(surveying, "fitted_again", fitted_again)
    survey(model, base.bench, nominal, base.begins, Silent(), known)
    assert again == [(MATE, IDLE), (MATE,), (KEY,)]


@pytest.mark.parametrize(("times", "surveys"), [(1.0, 1), (3.0, 1), (10.0, 2)])
def test_all_is_begun_anew_where_the_nominal_model_had_lost_its_way(enlarged, monkeypatch, times, surveys):
    """It left so many times as much as it does from where the best effect stands; what was found there is
    not forgotten."""
    model, base = enlarged
    nominal = nominal_on(model, base.bench, base.point)
    astray = dataclasses.replace(nominal, misfit=times * nominal.misfit, cost=times * nominal.cost)
    right = released(model, base.bench, with_effect(model, base, nominal, MATE))
    (promise,) = (p for p in screen(model, base.bench, nominal, shapes=[]).promises if p.key == MATE)
    began: list[float] = []

    def contest(_model, _bench, begin, *_):
        began.append(begin.misfit)
        return [Explanation((MATE,), promise, right)] if len(began) == 1 else []

    monkeypatch.setattr(surveying, "contest", contest)
    monkeypatch.setattr(surveying, "second_look", lambda *_: [])
    seen = survey(model, base.bench, astray, base.begins, Silent())
    assert len(began) == surveys and began[0] == astray.misfit
    assert seen.nominal.misfit == began[-1] <= (times if surveys == 1 else 1.2) * nominal.misfit
    assert [e.keys for e in seen.found] == [(MATE,)]
    assert seen.least == pytest.approx(right.misfit, rel=0.05)


def tried_outright(enlarged, monkeypatch, share: float, bench: Bench, floor: float) -> set[str]:
    """The effects that a survey tries outright where the best that it has found leaves this share of what
    the nominal model does."""
    model, base = enlarged
    nominal = nominal_on(model, base.bench, base.point)
    found = dataclasses.replace(nominal, misfit=share * nominal.misfit, free=model.nuisances())
    (promise,) = (p for p in screen(model, base.bench, nominal, shapes=[]).promises if p.key == MATE)
    asked: set[str] = set()

    def tried(_model, _bench, _nominal, promises, *_):
        asked.update(promise.key for promise in promises)
        return []

    monkeypatch.setattr(surveying, "contest", lambda *_: [Explanation((MATE,), promise, found)])
    monkeypatch.setattr(surveying, "freed", lambda _model, _bench, explanations: [*explanations])
    monkeypatch.setattr(surveying, "floor_of", lambda *_: floor)
    monkeypatch.setattr(surveying, "outright", tried)
    survey(model, bench, nominal, base.begins, Silent())
    return asked


@pytest.mark.parametrize(("share", "all_of_them"), [(0.97, True), (0.6, True), (0.45, False)])
def test_where_no_effect_leads_anywhere_all_are_tried_outright(enlarged, monkeypatch, share, all_of_them):
    """The nominal model may be astray where the linearised one is of no help, or of little where it leaves
    much. Else those of one sign are."""
    asked = tried_outright(enlarged, monkeypatch, share, enlarged[1].bench, 1.0)
    assert ({KEY, MATE, IDLE} <= asked) is all_of_them
    assert "end_stop" in asked and (all_of_them or {KEY, MATE, IDLE}.isdisjoint(asked))


@pytest.mark.parametrize("weighed", [False, True])
def test_what_was_overlooked_is_tried_once_residuals_are_weighed_by_scatter(enlarged, monkeypatch, weighed):
    """Where an effect leads somewhere and much does not repeat itself, that is weighed first, and all is
    surveyed again; what an effect leaves then, something else may explain."""
    bench = dataclasses.replace(enlarged[1].bench, scatters=weighed)
    assert ("end_stop" in tried_outright(enlarged, monkeypatch, 0.45, bench, 2.0)) is weighed


def test_lanes_are_lent_only_to_what_lost_ones_may_have_hidden(enlarged, monkeypatch):
    """What leaves far more of a typical lane than the best is not lent that one's lanes."""
    model, base = enlarged
    nominal = nominal_on(model, base.bench, base.point)
    (promise,) = (p for p in screen(model, base.bench, nominal, shapes=[]).promises if p.key == MATE)

    def leaving(share: float) -> Explanation:
        cost, misfit = share * nominal.cost, share * nominal.misfit
        fit = dataclasses.replace(nominal, cost=cost, misfit=misfit, freed=True)
        return Explanation((MATE,), promise, fit)

    lent: list[float] = []
    monkeypatch.setattr(surveying, "borrowed", lambda _model, _bench, fit, *_: lent.append(fit.misfit) or fit)
    found = [leaving(share) for share in (1.0, 1.2, 2.0)]
    surveying.freed(model, base.bench, found)
    assert lent == [e.refit.misfit for e in found[:2]]


def test_traces_that_lie_close_are_collinear_either_way_and_none_is_with_itself():
    cosine = np.array([[1.0, 0.58, 0.1], [0.58, 1.0, 0.48], [0.1, 0.48, 1.0]])
    seen: Any = types.SimpleNamespace(keys=("peak", "strengthening", "hum"), cosine=cosine)
    assert collinear(seen) == {"peak": ["strengthening"], "strengthening": ["peak"], "hum": []}
