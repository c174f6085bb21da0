"""Lanes that have lost an event, and how they find it again."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.cost import BROKEN
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import START
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import handed_on, released, settled
from jaxstick.effects.displacement_gain import DisplacementGain
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Noise
from tests.fitting.diagnosis.grounded import fitted_from_the_truth, from_the_truth, laid_out
from tests.fitting.reference_data import TRUTH, WRONG, dataset, noisy, own_run

LOST = slice(4, 7)


@pytest.fixture(scope="module")
def fitted() -> tuple[Model, Bench, Refit]:
    """A record of the 1987 rig, its lanes fitted from the true constants on."""
    model, bench, fit = fitted_from_the_truth(1000, WRONG)
    return model, bench, released(model, bench, fit, wander=False)


@pytest.fixture(scope="module")
def enlarged() -> tuple[Model, Bench, Refit]:
    """The same with a displacement that is read 6 % too large by a sensor of little noise, and a model that
    knows it."""
    gain, noise = DisplacementGain(0.06), Noise(displacement=1e-6, friction=0.03)
    exact = own_run(SineDrive(1.5, 10.325e-3), effects={"gain": gain}, samples=1000)
    run = noisy(exact, np.random.default_rng(3), noise)
    model, bench = laid_out(dataset(run, assumed=WRONG, noise=noise))
    coordinates = model.origin(TRUTH)
    (place,) = model.index("displacement_gain.gain")
    coordinates[place] = model.members[place].to_coordinate(gain.gain)
    return model, bench, freed_from_the_truth(model, bench, ("displacement_gain",), coordinates)


def freed_from_the_truth(model: Model, bench: Bench, keys: tuple[str, ...], coordinates: np.ndarray) -> Refit:
    attached = model.sharing.together(keys) if keys else ()
    return released(model, bench, from_the_truth(model, bench, attached, coordinates), wander=False)


def spoilt(fitted: tuple[Model, Bench, Refit], lanes: slice) -> Refit:
    """The fit with some lanes thrown far from where they were."""
    model, bench, fit = fitted
    own = fit.point.own.copy()
    own[lanes, :START] += np.array([2e-4, 0.05, -6.0])
    point = dataclasses.replace(fit.point, own=own)
    (found,) = refit(model, bench, [point], [fit.free], iterations=0, wander=False)
    return found


def test_a_lane_that_is_no_number_spoils_no_other_and_is_freed(fitted):
    model, bench, fit = fitted
    own = fit.point.own.copy()
    own[LOST.start, 0] = np.nan
    point = dataclasses.replace(fit.point, own=own)
    (found,) = refit(model, bench, [point], [fit.free], wander=False)
    others = np.arange(len(own)) != LOST.start
    assert found.cost[LOST.start] == BROKEN
    assert found.cost[others] == pytest.approx(fit.cost[others], rel=0.01)
    assert np.isfinite(found.misfit) and np.isfinite(found.point.coordinates).all()
    again = released(model, bench, found, wander=False)
    assert again.misfit == pytest.approx(fit.misfit, rel=1e-3)


@pytest.mark.parametrize("records", ["fitted", "enlarged"])
def test_a_lane_goes_on_where_the_one_before_it_passes_by(records, request, monkeypatch):
    """Without any other start, also where several follow one another, and also where sensors read something
    else than there is."""
    model, bench, fit = whole = request.getfixturevalue(records)
    assert fit.misfit < 1.2
    lost = spoilt(whole, LOST)
    assert np.all(lost.cost[LOST] > 20 * fit.cost[LOST])
    monkeypatch.setattr("fitting.diagnosis.refits.release.MANY", 0.0)
    again = released(model, bench, lost, wander=False)
    assert again.misfit == pytest.approx(fit.misfit, rel=0.02)
    assert np.all(again.cost[LOST] < 1.2 * fit.cost[LOST])


def test_what_is_handed_on_is_the_motion_and_not_its_reading(enlarged):
    """A lane's start is where the lane before it is at that time, though the sensor reads 6 % more."""
    model, bench, fit = enlarged
    later = np.arange(1, len(bench.lanes))
    handed, known = handed_on(model, bench, fit.point, later)
    assert known.all()
    stroke, speed, force = np.ptp(fit.point.own[:, :START], axis=0)
    miss = np.abs(handed - fit.point.own[later])
    assert np.all(np.median(miss[:, :START], axis=0) < 0.01 * np.array([stroke, speed, force]))


def test_a_first_lane_is_freed_by_scattered_starts(fitted):
    """No lane goes before it."""
    model, bench, fit = fitted
    lost = spoilt(fitted, slice(1))
    assert lost.cost[0] > 20 * fit.cost[0]
    assert released(model, bench, lost, wander=False).cost[0] < 1.2 * fit.cost[0]


def test_lanes_settle_that_are_all_a_little_off(fitted):
    """None of them lies far above the typical one, so that none is lost."""
    model, bench, fit = fitted
    own = fit.point.own + np.array([2e-5, 4e-3, 0.0, 0.0, 0.0])
    (off,) = refit(
        model, bench, [dataclasses.replace(fit.point, own=own)], [fit.free], iterations=0, wander=False
    )
    assert off.misfit > 2 * fit.misfit and off.cost.max() < 4 * np.median(off.cost)
    again = released(model, bench, off, wander=False)
    assert again.misfit == pytest.approx(fit.misfit, rel=1e-3)


def test_a_fit_without_lost_lanes_is_left_as_it_is(fitted):
    model, bench, fit = fitted
    again = released(model, bench, dataclasses.replace(fit, freed=False), wander=False)
    assert again.point is fit.point and again.misfit == fit.misfit


def test_what_has_been_freed_is_not_freed_again_unless_it_is_fitted_anew(fitted, monkeypatch):
    model, bench, fit = fitted
    monkeypatch.setattr(
        "fitting.diagnosis.refits.release._released", lambda *_: pytest.fail("freed once more")
    )
    assert fit.freed and released(model, bench, fit, wander=False) is fit
    assert not fit.stripped(model, ["constant_force"]).freed
    assert not spoilt(fitted, LOST).freed


def test_only_lanes_that_have_not_settled_go_on(fitted, monkeypatch):
    """A few that are a little off are brought back; the others are looked at once."""
    model, bench, fit = fitted
    own = fit.point.own.copy()
    own[LOST, 0] += 2e-5
    seen: list[int] = []
    columns = Model.columns

    def counted(self, jobs):
        seen.extend(len(job.own) for job in jobs)
        return columns(self, jobs)

    monkeypatch.setattr(Model, "columns", counted)
    found = settled(model, bench, dataclasses.replace(fit.point, own=own))
    assert seen[0] == len(bench.lanes) and max(seen[1:]) < len(bench.lanes) / 2
    assert np.all(found.before[LOST] > 2 * fit.cost[LOST])
    assert found.cost == pytest.approx(fit.cost, rel=1e-3, abs=0.01)
