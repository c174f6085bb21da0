"""Friction that drifts beside what explains the rest, where friction is free to wander."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import START
from fitting.diagnosis.noise.ground import Ground
from fitting.diagnosis.noise.repeatability import wanders
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.in_step import in_step
from fitting.diagnosis.which.screen import Promise
from fitting.diagnosis.which.survey import nominal_on
from fitting.progress import Silent
from jaxstick.effects.force_delay import ForceDelay
from jaxstick.effects.friction_drift import FrictionDrift
from jaxstick.effects.periodic_track import PeriodicTrack
from tests.fitting.diagnosis.grounded import grounded, with_effect

RATE = 0.08
DELAY = ForceDelay(3e-3)
RIPPLE = PeriodicTrack(0.05, -0.05, 3e-3)


def alone(model: Model, base: Ground, nominal: Refit, key: str) -> Explanation:
    nothing = np.zeros(0)
    promise = Promise(key, nothing, 0.0, nothing, 1.0, nothing, nothing, nothing, nothing, nothing)
    return Explanation((key,), promise, with_effect(model, base, nominal, key))


def test_a_drift_that_was_taken_for_wandering_is_found_beside_what_leaves_nothing_else():
    _, model, base = grounded({"friction_drift": FrictionDrift(RATE), "force_delay": DELAY}, 21)
    nominal = nominal_on(model, base.bench, base.point)
    leader = alone(model, base, nominal, "force_delay")
    assert wanders(leader.refit) and leader.refit.misfit < 1.2
    found = {frozenset(e.keys): e.refit for e in in_step(model, base.bench, nominal, [leader], [], Silent())}
    both = found[frozenset({"friction_drift", "force_delay"})]
    assert both.misfit < 1.02 * leader.refit.misfit and not wanders(both)
    values = model.values(both.point.coordinates, ("friction_drift.rate", "force_delay.delay"))
    assert values == pytest.approx({"friction_drift.rate": RATE, "force_delay.delay": 3e-3}, rel=0.1)


def test_a_drift_is_found_by_itself():
    _, model, base = grounded({"friction_drift": FrictionDrift(RATE)}, 23)
    nominal = nominal_on(model, base.bench, base.point)
    assert wanders(nominal)
    first, *_ = in_step(
        model, base.bench, nominal, [alone(model, base, nominal, "force_delay")], [], Silent()
    )
    assert first.keys == ("friction_drift",) and not wanders(first.refit)
    assert model.values(first.refit.point.coordinates, ("friction_drift.rate",)) == pytest.approx(
        {"friction_drift.rate": RATE}, rel=0.1
    )


def test_friction_that_wanders_otherwise_is_no_drift():
    """A ripple of the track is taken for wandering, too, but in every run for another."""
    _, model, base = grounded({"periodic_track": RIPPLE}, 22)
    nominal = nominal_on(model, base.bench, base.point)
    leader = alone(model, base, nominal, "force_delay")
    assert wanders(nominal) and np.std(nominal.point.own[:, START]) > 2e-3
    assert in_step(model, base.bench, nominal, [leader], [], Silent()) == []


def test_an_effect_that_the_rig_has_already_is_not_sought():
    _, model, base = grounded({"friction_drift": FrictionDrift(RATE)}, 24)
    nominal = nominal_on(model, base.bench, base.point)
    effects = {key: effect for key, effect in model.shelf.effects.items() if key != "friction_drift"}
    model.shelf = dataclasses.replace(model.shelf, effects=effects)
    assert wanders(nominal)
    assert (
        in_step(model, base.bench, nominal, [alone(model, base, nominal, "force_delay")], [], Silent()) == []
    )
