"""When a search is over: where a step promises less than the records can tell."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pytest

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import OWN
from fitting.diagnosis.refits import search as searching
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.search import ENOUGH, ENOUGH_OF_SCATTER, LEAST_DAMPED, STUCK, Search
from jaxstick.effects.slip_weakening import SlipWeakening
from tests.fitting.diagnosis.grounded import fitted_from_the_truth, from_the_truth, laid_out, noisy_runs
from tests.fitting.reference_data import TRUTH, dataset


@pytest.fixture(scope="module")
def fitted() -> tuple[Model, Bench, Refit]:
    """A record of the 1987 rig, its lanes fitted from the true constants on."""
    return fitted_from_the_truth(600)


def looked_at(
    model: Model, bench: Bench, point: Point, free: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> tuple[Refit, int]:
    """The refit from a point on, and at how many points the motion was computed for it."""
    plain, count = model.columns, 0

    def counted(jobs):
        nonlocal count
        count += 1
        return plain(jobs)

    monkeypatch.setattr(model, "columns", counted)
    (found,) = refit(model, bench, [point], [free], wander=False)
    monkeypatch.undo()
    return found, count


def test_a_step_that_promises_nothing_is_not_taken(fitted, monkeypatch):
    """The search has converged: it is over once the first linearisation says so."""
    model, bench, fit = fitted
    (fit,) = refit(model, bench, [fit.point], [fit.free], wander=False)
    again, count = looked_at(model, bench, fit.point, fit.free, monkeypatch)
    assert count == 1 and again.misfit == fit.misfit and again.iterations == 0


@pytest.mark.parametrize(
    ("share", "plain", "weighed"), [(2e-5, False, False), (5.5e-5, True, False), (3e-4, True, True)]
)
def test_a_step_that_promises_something_is(fitted, monkeypatch, share, plain, weighed):
    """From a C that is off by as much as a promise is worth a step: where residuals are weighed by what does
    not repeat itself, from one that is farther off."""
    model, bench, fit = fitted
    (place,) = model.index("C")
    member, coordinates = model.members[place], fit.point.coordinates.copy()
    coordinates[place] = member.to_coordinate((1 + share) * member.to_value(coordinates[place]))
    point = dataclasses.replace(fit.point, coordinates=coordinates)
    scattering = dataclasses.replace(bench, scatters=True)
    for each, enough, taken in ((bench, ENOUGH, plain), (scattering, ENOUGH_OF_SCATTER, weighed)):
        found, count = looked_at(model, each, point, fit.free, monkeypatch)
        assert (count > 1) == taken
        assert found.misfit < fit.misfit * (1 + enough)


def test_damping_grows_with_every_step_that_is_refused_and_does_not_vanish(fitted):
    """After however many steps that were taken in a row, few are refused that are all but the same."""
    model, bench, fit = fitted
    (seen,) = model.columns([job(model, bench, fit.point)])

    def dampings(costs: Sequence[float]) -> list[float]:
        search = Search(model, bench, fit.point, fit.free, False)
        found = []
        for number, cost in enumerate(costs):
            columns = dataclasses.replace(seen, residual=cost * seen.residual)
            search.see(fit.point, columns, first=number == 0)
            found.append(search.damping)
        return found[1:]

    assert dampings([1.0, 1.1, 1.1, 1.1, 0.9, 1.0]) == pytest.approx([1e-2, 1e-1, 1.0, 0.1, 1.0])
    taken = dampings(np.geomspace(1.0, 0.1, 8).tolist())
    assert taken[0] == pytest.approx(LEAST_DAMPED) and min(taken) == LEAST_DAMPED


def test_steps_that_are_short_end_no_search_until_it_is_stuck(fitted):
    """A step that is taken, or promised, and gains next to nothing ends it only where damping is light."""
    model, bench, fit = fitted
    (fit,) = refit(model, bench, [fit.point], [fit.free], wander=False)
    (seen,) = model.columns([job(model, bench, fit.point, fit.free)])
    search = Search(model, bench, fit.point, fit.free, False)
    search.see(fit.point, seen, first=True)
    lower = dataclasses.replace(seen, residual=(1 - 1e-6) * seen.residual)
    for damping, over in ((LEAST_DAMPED, True), (1e2, False)):
        search.damping = damping
        search.step()
        assert search.over == over
        search.damping, taken = damping, search.taken
        search.see(fit.point, lower, first=False)
        assert search.taken == taken + 1 and search.over == over
        lower = dataclasses.replace(lower, residual=(1 - 1e-6) * lower.residual)
    search.damping = 0.5 * STUCK
    search.see(fit.point, dataclasses.replace(seen, residual=2 * seen.residual), first=False)
    assert search.over


def test_a_lane_whose_start_is_not_told_apart_spoils_no_refit(fitted, monkeypatch):
    """Where a lane's motion grows beyond bounds, what it has of its own all does the same."""
    model, bench, fit = fitted
    plain = searching.normal

    def degenerate(columns):
        gradient, curvature = plain(columns)
        curvature[3, -OWN:, -OWN:] = 1e12
        return gradient, curvature

    monkeypatch.setattr(searching, "normal", degenerate)
    (found,) = refit(model, bench, [fit.point], [fit.free], iterations=1, wander=False)
    assert {*found.told} == {*fit.free.tolist()}
    assert all(told > 0 for told in found.told.values())


@pytest.mark.parametrize("weakening", [0.0, 0.3])
def test_the_shape_of_an_effect_is_told_where_it_acts(weakening):
    """Slip weakening: over which distance it fades, and how, is told where there is some, and by the prior
    alone where there is none."""
    effects = {"slip_weakening": SlipWeakening(weakening)}
    model, bench = laid_out(dataset(*noisy_runs({1.5: effects}, 3)))
    fit = from_the_truth(model, bench, model.sharing.together(("slip_weakening",)), model.origin(TRUTH))
    free = np.concatenate([fit.free, model.of("slip_weakening")])
    (found,) = refit(model, bench, [fit.point], [free], wander=False)
    strength, *shape = (found.told[number] for number in model.of("slip_weakening").tolist())
    assert strength > 100 and len(shape) == 2
    assert min(shape) > 10 if weakening else max(shape) < 1
