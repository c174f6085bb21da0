"""What contains the nominal model and has ended above it, and what has ended a little above the best."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.which import contained
from fitting.diagnosis.which.contained import CLOSE, brought_level, none_above
from fitting.diagnosis.which.explanation import Explanation
from tests.fitting.diagnosis.grounded import fitted_from_the_truth
from tests.fitting.reference_data import WRONG

LOST = slice(2, 9)
EARLY = 2e-6


@pytest.fixture(scope="module")
def nominal() -> tuple[Model, Bench, Refit]:
    """A record of the 1987 rig, the nominal model fitted from the true constants on."""
    return fitted_from_the_truth(1000, WRONG)


def explained(nominal: tuple[Model, Bench, Refit], key: str, off: Any, lanes: slice) -> Explanation:
    """An effect beside it at null, with some lanes thrown off."""
    model, bench, fit = nominal
    own = fit.point.own.copy()
    own[lanes, : len(off)] += off
    point = dataclasses.replace(fit.point, own=own, keys=model.sharing.fitted((key,)))
    free = np.concatenate([fit.free, model.of(key)])
    (found,) = refit(model, bench, [point], [free], iterations=0, wander=False)
    promise: Any = None
    return Explanation((key,), promise, found)


def test_what_has_lost_lanes_ends_no_higher_than_the_nominal_model(nominal):
    model, bench, fit = nominal
    astray = explained(nominal, "friction_drift", np.array([2e-4, 0.05, -6.0]), LOST)
    good = explained(nominal, "force_offset", np.zeros(3), LOST)
    assert astray.refit.misfit > 3 * fit.misfit
    best, other = none_above(model, bench, fit, [good, astray])
    assert {best.keys, other.keys} == {good.keys, astray.keys}
    assert best.refit.misfit <= other.refit.misfit <= 1.001 * fit.misfit


def test_what_is_no_rival_stays_as_it_is(nominal, monkeypatch):
    """Beside an explanation that leaves far less than the nominal model nothing else is fitted again."""
    model, bench, fit = nominal
    good = explained(nominal, "force_offset", np.zeros(3), LOST)
    astray = explained(nominal, "friction_drift", np.array([2e-4, 0.05, -6.0]), LOST)
    worse = dataclasses.replace(fit, misfit=2 * fit.misfit)
    for name in ("released", "borrowed"):
        monkeypatch.setattr(contained, name, None)
    assert none_above(model, bench, worse, [good, astray]) == [good, astray]


def test_what_has_stopped_a_little_above_the_best_is_brought_level(nominal):
    """Some lanes thrown off by two micrometres: a search that asks for more than they promise has
    stopped there. What leaves far more stays as it is, and so do two effects."""
    model, bench, _ = nominal
    best = explained(nominal, "force_offset", np.zeros(3), LOST)
    early = explained(nominal, "friction_drift", np.array([EARLY, 0.0, 0.0]), LOST)
    far = explained(nominal, "constant_force", np.array([1e-4, 0.0, 0.0]), LOST)
    pair = dataclasses.replace(early, keys=("friction_drift", "force_gain"))
    assert 1.002 < early.refit.misfit / best.refit.misfit < CLOSE < far.refit.misfit / best.refit.misfit
    found = {e.keys: e for e in brought_level(model, bench, [far, early, pair, best])}
    assert found[far.keys] is far and found[pair.keys] is pair and len(found) == 4
    assert found[early.keys].refit.misfit < 1.001 * best.refit.misfit
