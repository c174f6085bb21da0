"""Two effects that friction which may wander would hide."""

from __future__ import annotations

import pytest

from fitting.diagnosis.contest import best_of
from fitting.diagnosis.pairs import with_still_friction
from fitting.diagnosis.repeatability import wanders
from fitting.diagnosis.survey import survey
from fitting.progress import Silent
from jaxstick.effects.friction_drift import FrictionDrift
from jaxstick.effects.periodic_track import PeriodicTrack
from tests.fitting.diagnosis.grounded import grounded

PAIR = {"friction_drift": FrictionDrift(0.08), "periodic_track": PeriodicTrack(0.02, -0.02, 3e-3)}


def test_what_wandering_hides_is_found_with_still_friction():
    """A drift and a ripple of 3 %: a level for every segment takes the drift and part of the ripple over."""
    _, model, base = grounded(dict(PAIR), 12)
    seen = survey(model, base.bench, base.point, base.begins, Silent())
    leader = seen.found[0]
    assert wanders(seen.nominal) and wanders(leader.refit)
    found = with_still_friction(model, base.bench, seen.nominal, leader, seen.screen.shapes, Silent())
    best = min(best_of(found), key=lambda e: e.refit.misfit)
    assert {*best.keys} == {*PAIR} and not wanders(best.refit)
    assert best.refit.misfit < min(1.1, leader.refit.misfit)
    truth = {"friction_drift.rate": 0.08, "periodic_track.wavelength": 3e-3, "periodic_track.cosine": 0.02}
    assert model.values(best.refit.point.coordinates, tuple(truth)) == pytest.approx(truth, rel=0.2)
