"""Lanes that have lost an event, and how they find it again."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.laying import cut_in_step, lay, length
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import Bench, Point, Refit, refit
from fitting.diagnosis.release import released
from fitting.diagnosis.wander import LEAST, OWN, START
from fitting.problem import pose
from fitting.settings import Settings
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import TRUTH, WRONG, dataset, noisy, own_run

SUBSTEPS = 16
LOST = slice(4, 7)


@pytest.fixture(scope="module")
def fitted() -> tuple[Model, Bench, Refit]:
    """A record of the 1987 rig, its lanes fitted from the true constants on."""
    run = noisy(own_run(SineDrive(1.5, 10.325e-3), samples=1000), np.random.default_rng(3))
    problem = pose(dataset(run, assumed=WRONG), Settings(workers=2))
    model, samples = Model(problem, 2), length(problem)
    segments, phases = cut_in_step(problem.chosen, samples)
    bench = lay(problem, segments, phases, SUBSTEPS, samples, samples // 4)
    widths = np.full(OWN - START, LEAST)
    point = Point((), model.origin(TRUTH), np.zeros(1), np.asarray(bench.lanes.start), widths)
    (fit,) = refit(model, bench, [point], [model.index(*model.constants)], wander=False)
    return model, bench, released(model, bench, fit, wander=False)


def spoilt(fitted: tuple[Model, Bench, Refit], lanes: slice) -> Refit:
    """The fit with some lanes thrown far from where they were."""
    model, bench, fit = fitted
    own = fit.point.own.copy()
    own[lanes, :START] += np.array([2e-4, 0.05, -6.0])
    point = dataclasses.replace(fit.point, own=own)
    (found,) = refit(model, bench, [point], [fit.free], iterations=0, wander=False)
    return found


def test_a_lane_goes_on_where_the_one_before_it_passes_by(fitted, monkeypatch):
    """Without any other start, also where several follow one another."""
    model, bench, fit = fitted
    assert fit.misfit < 1.2
    lost = spoilt(fitted, LOST)
    assert np.all(lost.cost[LOST] > 20 * fit.cost[LOST])
    monkeypatch.setattr("fitting.diagnosis.release.MANY", 0.0)
    again = released(model, bench, lost, wander=False)
    assert again.misfit == pytest.approx(fit.misfit, rel=0.02)
    assert np.all(again.cost[LOST] < 1.2 * fit.cost[LOST])


def test_a_first_lane_is_freed_by_scattered_starts(fitted):
    """No lane goes before it."""
    model, bench, fit = fitted
    lost = spoilt(fitted, slice(1))
    assert lost.cost[0] > 20 * fit.cost[0]
    assert released(model, bench, lost, wander=False).cost[0] < 1.2 * fit.cost[0]


def test_a_fit_without_lost_lanes_is_left_as_it_is(fitted):
    model, bench, fit = fitted
    assert released(model, bench, fit, wander=False) is fit
