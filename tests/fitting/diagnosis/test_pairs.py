"""Two effects that friction which may wander would hide."""

from __future__ import annotations

from typing import Any

import pytest

from fitting.diagnosis import pairs
from fitting.diagnosis.explanation import best_of
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


def test_pairs_are_sought_beside_the_leader_kept_still(monkeypatch):
    """Friction that drifts may be all that the best effect leaves, and be taken for wandering: where that
    effect is not among those tried with still friction, it is there all the same."""
    _, model, base = grounded(dict(PAIR), 12)
    seen = survey(model, base.bench, base.point, base.begins, Silent())
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
