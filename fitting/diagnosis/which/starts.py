"""Where refits of promises begin."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.layout import Layout, with_strengths
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import START
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.refits.release import all_settled
from fitting.diagnosis.which.screen import Promise

OWN_REACH = 10.0
"""What lanes have of their own moves with an effect by at most so many standard deviations of their starts"""
FRICTION_REACH = 0.3
"""and as large a share of friction."""
FARTHEST = 30.0
LONG = 20.0
"""Where the strength of an effect is a time, a refit begins at so many typical sizes, too, `HEAT` steps
before the others: what a delay or a lag does is not in proportion to it, and from one that is too short a
search may end before it is long enough."""


class Approach(NamedTuple):
    """How refits begin: at which shares of the change that the linearised model expects, at most how many
    typical sizes from null, but for a share beyond the whole, which goes as far as is expected, up to
    `FARTHEST`; whether lanes settle first, whether what ends above the base, which it contains, begins once
    more at null, and whether a time begins `LONG`, too."""

    shares: tuple[float, ...]
    far: float
    settle: bool
    returns: bool
    long: bool


FROM_AFAR = Approach((0.7, 3.0), 6.0, False, True, True)
"""From a model that lacks the effect: what is expected there may be far off."""
FROM_NEARBY = Approach((0.5, 1.0), math.inf, True, False, False)
"""From a model that has another effect in its place, and may have gone a long way with it."""


class Start(NamedTuple):
    """Where a refit of a promise begins, on some lanes, and what is then free."""

    promise: Promise
    keys: tuple[str, ...]
    point: Point
    free: np.ndarray


def start(model: Model, base: Refit, promise: Promise, point: Point) -> Start:
    """A start of a promise on top of the effects that the base has, at a point of the base's lanes."""
    keys = *model.free_effects(base.free), promise.key
    point = dataclasses.replace(point, keys=model.sharing.fitted(keys))
    return Start(promise, keys, point, np.concatenate([base.free, model.of(promise.key)]))


def starts_of(
    model: Model,
    bench: Bench,
    base: Refit,
    promises: Sequence[Promise],
    few: np.ndarray,
    approach: Approach,
) -> list[Start]:
    """All starts of the promises on some lanes, several of each."""

    def at(promise: Promise, begin: Promise, share: float) -> Start:
        return start(model, base, promise, _begin(model, bench, base, begin, share, approach.far).take(few))

    starts = []
    for promise in promises:
        starts += [at(promise, promise, share) for share in approach.shares]
        if promise.second is not None:
            starts.append(at(promise, promise.second, 1.0))
    if not approach.settle:
        return starts
    points = all_settled(model, bench.take(few), [each.point for each in starts])
    return [each._replace(point=point) for each, point in zip(starts, points, strict=True)]


def long_starts(
    model: Model, bench: Bench, base: Refit, promises: Sequence[Promise], few: np.ndarray
) -> list[Start]:
    """A start at a long time on some lanes for each promise whose strength is a time."""
    return [
        start(model, base, p, _begin(model, bench, base, _long(model, p), 1.0, LONG).take(few))
        for p in promises
        if model.lasts(p.key)
    ]


def _begin(
    model: Model,
    bench: Bench,
    base: Refit,
    promise: Promise,
    share: float,
    far: float,
) -> Point:
    """Where a refit begins: at a share of the expected change, the free unknowns and what runs and lanes have
    of their own moved to make room for it."""
    expected = max(float(np.max(np.abs(promise.change))), 1e-300)
    if share > 1:
        far = max(far, min(expected, FARTHEST))
    share = min(share, far / expected)
    moved = promise.around + share * promise.room
    layout = Layout.of(model, bench, base.free)
    point = layout.moved(model, base.point, layout.values(base.point) + moved)
    point = with_strengths(model, bench, point, promise.key, share * promise.change)
    if len(promise.shape):
        point.coordinates[model.index(*model.shelf.shapes[promise.key])] = promise.shape
    coordinates = np.clip(point.coordinates, model.lower, model.upper)
    by_run = np.clip(point.by_run, model.lower[model.by_run], model.upper[model.by_run])
    own = own_at(bench, base, promise, share)
    return dataclasses.replace(point, coordinates=coordinates, by_run=by_run, own=own)


def _long(model: Model, promise: Promise) -> Promise:
    """The promise of a long time, for which nothing makes room beforehand, of a sign that it may have."""
    two_sided = model.two_sided(model.index(*model.shelf.strengths[promise.key]))
    change = np.where(two_sided, np.copysign(LONG, promise.change), LONG)
    still = {name: np.zeros_like(getattr(promise, name)) for name in ("room", "own_room")}
    return dataclasses.replace(promise, change=change, **still)


def own_at(bench: Bench, base: Refit, promise: Promise, share: float) -> np.ndarray:
    """What lanes have of their own at this share of the expected change."""
    reach = OWN_REACH * np.asarray(bench.lanes.start_deviation)
    reach[:, START:] = FRICTION_REACH
    return base.point.own + np.clip(promise.own_around + share * promise.own_room, -reach, reach)
