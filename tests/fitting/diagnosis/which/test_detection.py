"""What records could have shown: the limits of the effects that are screened."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from fitting.diagnosis.findings import Limit
from fitting.diagnosis.judging.judge import LEAST_INFLATION
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.which.detection import DETECTED, detection_limit, limits
from fitting.diagnosis.which.screen import Screen
from tests.fitting.diagnosis.grounded import screened

KEY, STRENGTHS = "asymmetric_friction", ["dry", "viscous"]


def seen_of(times: float = 1.0, dry: float = 0.0) -> tuple[Model, Screen]:
    """The screening of some effects of friction on a run whose noise is so many times the usual one and whose
    dry friction differs by this share between the directions."""
    whole = screened(times, dry)
    return whole.model, whole.seen


def limit_of(model: Model, seen: Screen, inflation: float = 1.0) -> Limit:
    return next(limit for limit in limits(model, seen, inflation) if limit.effect == KEY)


def test_every_strength_has_a_limit():
    model, seen = seen_of()
    found = limits(model, seen, 1.0)
    strengths = [f"{limit.effect}.{limit.strength}" for limit in found]
    assert strengths == [name for key in seen.keys for name in model.shelf.strengths[key]]
    assert [limit.strength for limit in found if limit.effect == KEY] == STRENGTHS
    assert all(limit.value > 0 and limit.unit for limit in found)
    for limit in found:
        place = seen.keys.index(limit.effect)
        assert limit.likest != limit.effect
        assert limit.cosine == max(np.delete(seen.cosine[place], place))
        assert limit.cosine == seen.cosine[place, seen.keys.index(limit.likest)]


def test_limits_are_those_of_the_usual_shape():
    model, seen = seen_of()
    promise = next(promise for promise in seen.usual if promise.key == KEY)
    assert [promise.key for promise in seen.usual] == list(seen.keys)
    assert limit_of(model, seen).value == detection_limit(model, promise, 1.0)
    best = tuple(dataclasses.replace(p, information=100 * p.information) for p in seen.promises)
    assert limits(model, dataclasses.replace(seen, promises=best), 1.0) == limits(model, seen, 1.0)


def test_the_limit_grows_with_the_noise():
    """Nearly: what is known beforehand of the constants does not."""
    once, thrice = (limit_of(*seen_of(times)).value for times in (1.0, 3.0))
    assert thrice / once == pytest.approx(3.0, rel=0.15)
    model, seen = seen_of()
    doubled = limit_of(model, seen, 4 * LEAST_INFLATION).value
    assert doubled == pytest.approx(2 * once, rel=1e-12)


def test_an_effect_far_beyond_its_limit_is_detected():
    model, seen = seen_of()
    limit = limit_of(model, seen).value
    quiet, _ = scored(seen)
    _, loud = seen_of(1.0, 3.0 * limit)
    score, change = scored(loud)
    assert quiet < LEAST_INFLATION * DETECTED < score
    scale = model.members[model.index(f"{KEY}.dry")[0]].scale
    assert change * scale == pytest.approx(3.0 * limit, rel=0.3)


def scored(seen: Screen) -> tuple[float, float]:
    """By how much letting the effect free would lower chi-square, and to which strength that leads."""
    promise = next(promise for promise in seen.usual if promise.key == KEY)
    return promise.score, float(promise.change[0])


def test_what_cannot_show_has_no_limit():
    """On this rig next to no friction is viscous. What leaves no trace is like nothing."""
    model, seen = seen_of()
    viscous = next(limit for limit in limits(model, seen, 1.0) if limit.strength == STRENGTHS[1])
    assert viscous.effect == KEY and math.isinf(viscous.value)
    place = seen.keys.index(KEY)
    usual = list(seen.usual)
    usual[place] = dataclasses.replace(usual[place], information=np.full(2, 1e-30))
    cosine = seen.cosine.copy()
    cosine[place], cosine[:, place] = 0.0, 0.0
    bare = limit_of(model, dataclasses.replace(seen, usual=tuple(usual), cosine=cosine))
    assert math.isinf(bare.value) and bare.likest is None and bare.cosine is None
