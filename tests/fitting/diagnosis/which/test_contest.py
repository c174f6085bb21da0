"""Refits that the way from the nominal model would lead astray: friction that differs between the directions,
on runs of the 1987 rig without a friction channel."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import START
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import released
from fitting.diagnosis.which import contest as contesting
from fitting.diagnosis.which import finals
from fitting.diagnosis.which.afresh import afresh, outright
from fitting.diagnosis.which.contest import contest
from fitting.diagnosis.which.finals import hidden_by_lost_lanes
from fitting.diagnosis.which.screen import Promise, screen
from fitting.diagnosis.which.starts import FROM_AFAR, Approach
from fitting.progress import Silent
from jaxstick.effects.asymmetric_friction import AsymmetricFriction
from jaxstick.effects.force_hysteresis import ForceHysteresis
from jaxstick.effects.frictional_memory import FrictionalMemory
from tests.fitting.diagnosis.grounded import UNEVEN, from_the_truth, laid_out, noisy_runs, screened
from tests.fitting.reference_data import TRUTH, dataset

DRY = 0.2
ASTRAY = {"A": 0.02, "B": 20.0, "C": 2.0, "D": 40.0, "k1": 5e3}
"""Constants of a friction that is nearly all viscous, on a soft contact."""
FAR_TOO_FAR = 60.0
LONG_LAG = 0.05
PLAY, LAGS = "force_hysteresis", "frictional_memory"


class Unrecorded(NamedTuple):
    model: Model
    bench: Bench
    nominal: Refit
    promise: Promise


@pytest.fixture(scope="module")
def unrecorded() -> Unrecorded:
    """The nominal model fitted to the motion alone from constants that are `ASTRAY`, and what asymmetry
    promises there."""
    effects = {UNEVEN: AsymmetricFriction(DRY, 0.0)}
    runs = noisy_runs({0.6: effects, 1.5: effects, 2.1: effects}, 3)
    model, bench = laid_out(dataset(*(dataclasses.replace(run, friction=None) for run in runs)))
    nominal = from_the_truth(model, bench, model.sharing.together((UNEVEN,)), model.origin(ASTRAY))
    seen = screen(model, bench, nominal, own_group=True, shapes=[])
    return Unrecorded(model, bench, nominal, next(p for p in seen.promises if p.key == UNEVEN))


def dry(model: Model, fit: Refit) -> float:
    (value,) = model.values(fit.point.coordinates, [f"{UNEVEN}.dry"]).values()
    return value


def test_what_ends_above_the_model_that_it_contains_begins_once_more_at_null(unrecorded: Unrecorded):
    model, bench, nominal, promise = unrecorded

    def ended(returns: bool) -> float:
        approach = Approach((FAR_TOO_FAR,), math.inf, False, returns, False)
        (found,) = contest(model, bench, nominal, [promise], 1, Silent(), approach)
        return found.refit.misfit

    assert ended(False) > nominal.misfit
    assert ended(True) < nominal.misfit


def test_a_long_lag_is_found_that_the_linearised_model_expects_to_be_short():
    effects = {LAGS: FrictionalMemory(LONG_LAG)}
    model, bench = laid_out(dataset(*noisy_runs(dict.fromkeys((0.6, 1.5, 2.1), effects), 3)))
    nominal = from_the_truth(model, bench, model.sharing.together((LAGS,)), model.origin(TRUTH))
    seen = screen(model, bench, nominal, own_group=True)
    (promise,) = (p for p in seen.promises if p.key == LAGS)

    strength = f"{LAGS}.lag"
    (place,) = model.index(strength)
    assert model.members[place].to_value(promise.change[0]) < 0.6 * LONG_LAG
    (found,) = contest(model, bench, nominal, [promise], 1, Silent(), FROM_AFAR)
    fit = released(model, bench, found.refit)
    lag = model.values(fit.point.coordinates, [strength])[strength]
    assert fit.misfit < 1.1
    assert lag == pytest.approx(LONG_LAG, rel=0.1)


def test_what_lost_lanes_hide_goes_to_the_end_as_well():
    """What leaves least of a typical lane, an effect once, if that is less than the best leave of one, or
    hardly more and some are lost, of an effect that is not among the best anyway."""

    def tried(key: str, misfit: float, typical: float) -> Any:
        return SimpleNamespace(keys=(key,), refit=SimpleNamespace(misfit=misfit, typical=lambda _: typical))

    best = [tried("best", 1.1, 1.0), tried("next", 1.2, 0.8)]
    others = [
        tried("lost", 9.0, 0.7),
        tried("lost", 9.0, 0.6),
        tried("far", 9.0, 0.79),
        tried("best", 3.0, 0.65),
        tried("third", 5.0, 0.71),
    ]
    heat: Any = None
    assert hidden_by_lost_lanes(heat, [*others, *best], best) == [others[1], others[3]]
    assert hidden_by_lost_lanes(heat, best, best) == []
    near, none_lost, again = tried("near", 2.0, 0.85), tried("whole", 1.2, 0.85), tried("next", 3.0, 0.82)
    assert hidden_by_lost_lanes(heat, [*best, others[2], near, none_lost, again], best) == [others[2], near]
    assert hidden_by_lost_lanes(heat, [*best, tried("worse", 2.0, 0.9)], best) == []


def test_an_effect_is_found_afresh_where_its_lack_has_led_the_constants_astray(unrecorded: Unrecorded):
    """From constants that are off by a fifth; the refit has not been looked after for lost lanes yet."""
    model, bench, nominal, promise = unrecorded
    rough = {name: 1.2 * value for name, value in TRUTH.items()}
    begins = np.array([model.origin(each)[model.index(*model.constants)] for each in (ASTRAY, rough)])
    (found,) = afresh(model, bench, nominal, begins, [promise], 1, Silent())
    assert found.keys == (UNEVEN,) and dry(model, found.refit) == pytest.approx(DRY, rel=0.05)
    constants = model.values(found.refit.point.coordinates, ("C", "k1"))
    assert constants == pytest.approx({name: TRUTH[name] for name in constants}, rel=0.05)
    (led,) = contest(model, bench, nominal, [promise], 1, Silent())
    assert led.refit.misfit > 10 * found.refit.misfit


def test_what_cannot_be_seen_in_the_records_is_not_tried_afresh(unrecorded: Unrecorded):
    model, bench, nominal, promise = unrecorded
    unseen = dataclasses.replace(promise, information=np.zeros(2))
    begins = model.origin(ASTRAY)[model.index(*model.constants)][None]
    assert afresh(model, bench, nominal, begins, [unseen], 1, Silent()) == []


def test_an_effect_that_shows_nothing_at_null_is_tried_outright():
    """The force channel has a play of a third of the friction: at null no play does anything."""
    play = {PLAY: ForceHysteresis(0.3 * TRUTH["C"])}
    model, bench = laid_out(dataset(*noisy_runs({0.9: play, 2.1: play}, 6)))
    nominal = from_the_truth(model, bench, model.sharing.together((PLAY,)), model.origin(TRUTH))
    promises = screen(model, bench, nominal, own_group=True, shapes=[]).promises
    found = outright(model, bench, nominal, promises, len(promises), Silent())
    best = min(found, key=lambda e: e.refit.misfit)
    assert best.keys == (PLAY,)
    (width,) = model.values(best.refit.point.coordinates, [f"{PLAY}.width"]).values()
    assert width == pytest.approx(0.3 * TRUTH["C"], rel=0.1)


def test_a_fault_of_a_sensor_that_was_not_there_is_not_tried_outright():
    runs = [dataclasses.replace(run, friction=None) for run in noisy_runs({0.9: {}, 2.1: {}}, 6)]
    model, bench = laid_out(dataset(*runs))
    nominal = from_the_truth(model, bench, model.sharing.together((PLAY,)), model.origin(TRUTH))
    promises = screen(model, bench, nominal, own_group=True, shapes=[]).promises
    faults = [promise for promise in promises if promise.key in (PLAY, "force_lowpass")]
    assert len(faults) == 2 and outright(model, bench, nominal, faults, 2, Silent()) == []


def test_an_effect_of_either_sign_is_tried_outright_with_both():
    uneven = {UNEVEN: AsymmetricFriction(-DRY, 0.0)}
    model, bench = laid_out(dataset(*noisy_runs({0.9: uneven, 2.1: uneven}, 7)))
    nominal = from_the_truth(model, bench, model.sharing.together((UNEVEN,)), model.origin(ASTRAY))
    seen = screen(model, bench, nominal, own_group=True, shapes=[])
    promise = next(p for p in seen.promises if p.key == UNEVEN)
    (found,) = outright(model, bench, nominal, [promise], 1, Silent())
    assert dry(model, found.refit) == pytest.approx(-DRY, rel=0.2)


def test_lanes_that_sit_out_the_contest_begin_where_its_winner_asks_them_to(monkeypatch: pytest.MonkeyPatch):
    """No more than half as far from where they end, in standard deviations of starts, as they are without
    the effect."""
    model, bench, base, seen = screened(1.0, 0.01)
    promise = next(promise for promise in seen.usual if promise.key == UNEVEN)
    whole, begun = finals._everywhere, []

    def noted(model: Model, bench: Bench, own: np.ndarray, few: np.ndarray, point: Point) -> Point:
        begun.append((own, few))
        return whole(model, bench, own, few, point)

    monkeypatch.setattr(finals, "_everywhere", noted)
    (found,) = contest(model, bench, base, [promise], 1, Silent(), wander=False)
    ((own, few),) = begun
    rest = np.setdiff1d(np.arange(len(bench.lanes)), few)
    deviation = np.asarray(bench.lanes.start_deviation)[rest, :START]
    without, begins = (
        np.abs(found.refit.point.own - each)[rest, :START] / deviation for each in (base.point.own, own)
    )
    assert np.all(np.median(begins, axis=0)[1:] <= np.median(without, axis=0)[1:] / 2)
    assert np.median(without[:, 0]) > 0
    together, apart = (np.median(np.linalg.norm(each, axis=1)) for each in (begins, without))
    assert together <= apart / 2, (
        "displacements alone, the least of it, may lie within what starts are known to"
    )


def test_two_effects_that_end_above_one_of_them_take_up_where_that_one_stands(
    monkeypatch: pytest.MonkeyPatch,
):
    """A search that loses its lanes' starts ends where the single effect does, or lower."""
    model, bench, base, seen = screened(1.0, 0.05)
    promise = next(promise for promise in seen.usual if promise.key == UNEVEN)
    (alone,) = contest(model, bench, base, [promise], 1, Silent(), wander=False)
    beside = screen(model, bench, alone.refit, own_group=True, shapes=[])
    second = next(p for p in beside.promises if p.key != UNEVEN)
    ended, astray = contesting.final, list[float]()

    def lost(*given: Any, **named: Any) -> Any:
        (found,) = ended(*given, **named)
        own = found.refit.point.own + 0.1 * np.abs(found.refit.point.own).max(0)
        point = dataclasses.replace(found.refit.point, own=own)
        (left,) = refit(model, bench, [point], [found.refit.free], iterations=0)
        astray.append(left.misfit)
        return [dataclasses.replace(found, refit=left)]

    monkeypatch.setattr(contesting, "final", lost)
    (both,) = contest(model, bench, alone.refit, [second], 1, Silent(), wander=False)
    assert astray[0] > 2 * alone.refit.misfit
    assert {*both.keys} == {UNEVEN, second.key} and both.refit.misfit < 1.01 * alone.refit.misfit
