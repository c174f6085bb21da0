"""What records could have shown: the limits of the effects that are screened."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
import pytest

from fitting.diagnosis.detection import DETECTED, detection_limit, limits
from fitting.diagnosis.findings import Limit
from fitting.diagnosis.judge import LEAST_INFLATION
from fitting.diagnosis.laying import cut_in_step, lay, length
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import Point, refit
from fitting.diagnosis.screen import Screen, screen
from fitting.diagnosis.wander import LEAST, OWN, START
from fitting.problem import pose
from fitting.settings import Settings
from jaxstick.effects.asymmetric_friction import AsymmetricFriction
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Noise
from tests.fitting.reference_data import NOISE, TRUTH, dataset, own_run

KEY, STRENGTHS = "asymmetric_friction", ["dry", "viscous"]
SUBSTEPS = 16


@functools.cache
def screened(times: float = 1.0, dry: float = 0.0) -> tuple[Model, Screen]:
    """The screening of some effects of friction on a run of the 1987 rig whose noise is so many times the
    usual one and whose dry friction differs by this share between the directions."""
    random = np.random.default_rng(4)
    assert NOISE.displacement is not None and NOISE.friction is not None
    of_displacement, of_friction = times * NOISE.displacement, times * NOISE.friction
    exact = own_run(SineDrive(1.5, 10.325e-3), effects={KEY: AsymmetricFriction(dry, 0.0)}, samples=600)
    assert exact.friction is not None
    run = dataclasses.replace(
        exact,
        displacement=exact.displacement + of_displacement * random.standard_normal(600),
        friction=exact.friction + of_friction * random.standard_normal(600),
    )
    stated = dataclasses.replace(dataset(run), noise=Noise(of_displacement, of_friction))
    problem = pose(stated, Settings(workers=2))
    model, samples = Model(problem, 2), length(problem)
    segments, phases = cut_in_step(problem.chosen, samples)
    bench = lay(problem, segments, phases, SUBSTEPS, samples, samples // 4)
    own = np.asarray(bench.lanes.start)
    keys = model.together((KEY,))
    point = Point(keys, model.origin(TRUTH), np.zeros(1), own, np.full(OWN - START, LEAST))
    (fit,) = refit(model, bench, [point], [model.index(*model.constants)], wander=False)
    return model, screen(model, bench, fit, own_group=True, shapes=[])


def limit_of(model: Model, seen: Screen, inflation: float = 1.0) -> Limit:
    return next(limit for limit in limits(model, seen, inflation) if limit.effect == KEY)


def test_every_strength_has_a_limit():
    model, seen = screened()
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
    model, seen = screened()
    promise = next(promise for promise in seen.usual if promise.key == KEY)
    assert [promise.key for promise in seen.usual] == list(seen.keys)
    assert limit_of(model, seen).value == detection_limit(model, promise, 1.0)
    best = tuple(dataclasses.replace(p, information=100 * p.information) for p in seen.promises)
    assert limits(model, dataclasses.replace(seen, promises=best), 1.0) == limits(model, seen, 1.0)


def test_the_limit_grows_with_the_noise():
    """Nearly: what is known beforehand of the constants does not."""
    once, thrice = (limit_of(*screened(times)).value for times in (1.0, 3.0))
    assert thrice / once == pytest.approx(3.0, rel=0.15)
    model, seen = screened()
    doubled = limit_of(model, seen, 4 * LEAST_INFLATION).value
    assert doubled == pytest.approx(2 * once, rel=1e-12)


def test_an_effect_far_beyond_its_limit_is_detected():
    model, seen = screened()
    limit = limit_of(model, seen).value
    quiet, _ = scored(seen)
    _, loud = screened(1.0, 3.0 * limit)
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
    model, seen = screened()
    viscous = next(limit for limit in limits(model, seen, 1.0) if limit.strength == STRENGTHS[1])
    assert viscous.effect == KEY and math.isinf(viscous.value)
    place = seen.keys.index(KEY)
    usual = list(seen.usual)
    usual[place] = dataclasses.replace(usual[place], information=np.full(2, 1e-30))
    cosine = seen.cosine.copy()
    cosine[place], cosine[:, place] = 0.0, 0.0
    bare = limit_of(model, dataclasses.replace(seen, usual=tuple(usual), cosine=cosine))
    assert math.isinf(bare.value) and bare.likest is None and bare.cosine is None
