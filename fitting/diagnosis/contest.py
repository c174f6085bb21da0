"""The contest of starts: promises refitted from several beginnings, few of them to the end."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.bench import Bench, Point
from fitting.diagnosis.layout import Layout, with_strengths
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import ITERATIONS, Refit, refit, within_columns
from fitting.diagnosis.release import all_settled, settled
from fitting.diagnosis.screen import Promise
from fitting.diagnosis.wander import LEAST
from fitting.progress import Progress

THIN = 3
"""Starts compete on one lane in so many, for `HEAT` steps."""
HEAT = 8
SETTLE = 3
HOPELESS = 2.0
"""A search that is not on its way to less than so many times the lowest cost is given up."""


class Approach(NamedTuple):
    """How refits begin: at which shares of the change that the linearised model expects, at most how many
    typical sizes from null, and whether lanes settle first."""

    shares: tuple[float, ...]
    far: float
    settle: bool


FROM_AFAR = Approach((0.7, 3.0), 6.0, False)
"""From a model that lacks the effect: what is expected there may be far off."""
FROM_NEARBY = Approach((0.5, 1.0), math.inf, True)
"""From a model that has another effect in its place, and may have gone a long way with it."""


@dataclasses.dataclass(frozen=True)
class Explanation:
    """One effect or several, refitted, with the promise that brought it on the short list."""

    keys: tuple[str, ...]
    promise: Promise
    refit: Refit


def contest(
    model: Model,
    bench: Bench,
    base: Refit,
    promises: Sequence[Promise],
    finalists: int,
    progress: Progress,
    approach: Approach = FROM_AFAR,
    *,
    wander: bool = True,
) -> list[Explanation]:
    """The best refits of the most successful promises, each on top of the effects that the base has.

    Several starts of every promise compete on a part of the lanes; the best starts of the best promises, so
    many as `finalists`, are fitted to all of them, where friction keeps still unless it may `wander`.
    """
    few = np.arange(0, len(bench.lanes), THIN)
    heat = bench.take(few)
    points, frees, promised = [], [], []
    for promise in promises:
        free = within_columns(model, base.free, model.of(promise.key))
        keys = model.together(base.point.keys, promise.key)
        begins = [(promise, share) for share in approach.shares]
        if promise.second is not None:
            begins.append((promise.second, 1.0))
        for begin, share in begins:
            begun = _begin(model, bench, base, begin, share, keys, approach.far)
            points.append(begun.take(few))
            frees.append(free)
            promised.append(promise)
    if approach.settle:
        points = all_settled(model, heat, points)
    common = model.free_effects(base.free)
    progress.stage("pairs refitted" if common else "effects refitted", HEAT + ITERATIONS)
    tried = refit(
        model,
        heat,
        points,
        frees,
        iterations=HEAT,
        wander=bool(np.any(base.point.widths > LEAST)),
        progress=lambda: progress.advance(),
    )
    heats: dict[str, tuple[Promise, Refit]] = {}
    for promise, result in zip(promised, tried, strict=True):
        rival = heats.get(promise.key)
        if rival is None or result.misfit < rival[1].misfit:
            heats[promise.key] = promise, result
    final = sorted(heats.values(), key=lambda pair: pair[1].misfit)[:finalists]
    results = refit(
        model,
        bench,
        model.side_by_side(lambda pair: _everywhere(model, bench, base, few, pair[1].point), final),
        [result.free for _, result in final],
        wander=wander,
        hopeless=HOPELESS,
        progress=lambda: progress.advance(),
    )
    return [
        Explanation((*common, promise.key), promise, result)
        for (promise, _), result in zip(final, results, strict=True)
    ]


def best_of(explanations: Sequence[Explanation]) -> list[Explanation]:
    """Of explanations by the same effects the one with the lowest misfit."""
    best: dict[frozenset[str], Explanation] = {}
    for one in explanations:
        rival = best.get(frozenset(one.keys))
        if rival is None or one.refit.misfit < rival.refit.misfit:
            best[frozenset(one.keys)] = one
    return list(best.values())


def _everywhere(model: Model, bench: Bench, base: Refit, few: np.ndarray, point: Point) -> Point:
    """A point found on few lanes for all of them: the others' own settled at its unknowns."""
    rest = np.setdiff1d(np.arange(len(bench.lanes)), few)
    whole = point.among(base.point.own, few)
    found, _ = settled(model, bench.take(rest), whole.take(rest), iterations=SETTLE)
    return dataclasses.replace(point, own=found).among(whole.own, rest)


def _begin(
    model: Model,
    bench: Bench,
    base: Refit,
    promise: Promise,
    share: float,
    keys: tuple[str, ...],
    far: float,
) -> Point:
    """Where a refit begins: at a share of the expected change, the free unknowns and what runs have of their
    own moved to make room for it."""
    share *= min(1.0, far / max(float(np.max(np.abs(share * promise.change))), 1e-300))
    moved = promise.around + share * promise.room
    layout = Layout.of(model, bench, base.free)
    point = layout.moved(model, base.point, layout.values(base.point) + moved)
    point = with_strengths(model, bench, point, promise.key, share * promise.change)
    if len(promise.shape):
        point.coordinates[model.index(*model.shelf.shapes[promise.key])] = promise.shape
    coordinates = np.clip(point.coordinates, model.lower, model.upper)
    by_run = np.clip(point.by_run, model.lower[model.by_run], model.upper[model.by_run])
    return dataclasses.replace(point, keys=keys, coordinates=coordinates, by_run=by_run)
