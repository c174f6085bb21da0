"""Hypotheses on runs that took no part: only starts and levels of friction are found anew."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from fitting.diagnosis.how_far.elsewhere import elsewhere, in_place
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.layout import LEVELLED
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import LEAST, OWN, START
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import laid_out
from tests.fitting.reference_data import TRUTH, WRONG, dataset, noisy, own_run

HIGHER = 1.14
LOST = slice(4, 6)


@pytest.fixture(scope="module")
def others() -> tuple[Model, Bench, Point]:
    """Two runs of the 1987 rig, and constants with 14 % more friction than either has, which hardly wanders
    from lane to lane."""
    random = np.random.default_rng(8)
    runs = [
        noisy(own_run(SineDrive(f, 10.325e-3), samples=600, file=f"run-{f}.csv"), random) for f in (0.9, 2.1)
    ]
    model, bench = laid_out(dataset(*runs, assumed=WRONG))
    coordinates = model.origin({**TRUTH, **{name: HIGHER * TRUTH[name] for name in LEVELLED}})
    own, widths = np.asarray(bench.lanes.start), np.array([2e-3, LEAST])
    assert own.shape[1] == OWN
    return model, bench, Point((), coordinates, model.alike(bench.runs), own, widths)


def test_runs_may_all_rub_less_than_those_that_were_fitted(others):
    """Every run has its level, the mean of all is not held, and constants stay."""
    model, bench, point = others
    (fit,) = elsewhere(model, bench, [point])
    assert np.median(fit.cost / bench.dof()) == pytest.approx(1.0, abs=0.15)
    assert fit.point.by_run[:, 0] == pytest.approx(-math.log(HIGHER), abs=0.004)
    assert np.abs(fit.point.own[:, START]).max() < 5 * point.widths[0]
    assert np.array_equal(fit.point.coordinates, point.coordinates)
    assert np.array_equal(fit.point.widths, point.widths)


def test_a_lane_begins_where_another_hypothesis_has_it(others):
    """Lanes whose start is spoilt under one hypothesis are found from how they start under the other."""
    model, bench, point = others
    own = point.own.copy()
    own[LOST, :START] = np.array([0.03, -1.5, 40.0])
    astray = dataclasses.replace(point, own=own)
    (alone,) = elsewhere(model, bench, [astray])
    beside, kept = elsewhere(model, bench, [astray, point])
    assert (alone.cost[LOST] > 3 * kept.cost[LOST]).any()
    assert beside.cost == pytest.approx(kept.cost, rel=1e-2)


def test_other_lanes_and_their_runs_stay_in_place(others):
    model, bench, point = others
    second = np.flatnonzero(bench.run == 1)
    found = in_place(model, bench, point, second)
    assert np.array_equal(found.own[bench.run == 0], point.own[bench.run == 0])
    assert found.by_run[0, 0] == point.by_run[0, 0]
    assert found.by_run[1, 0] == pytest.approx(-math.log(HIGHER), abs=0.004)
    part = in_place(model, bench, point, second[::2])
    assert part.by_run[1, 0] == point.by_run[1, 0]
    assert not np.array_equal(part.own[second[::2]], point.own[second[::2]])
