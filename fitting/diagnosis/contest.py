"""The contest of starts: promises refitted from several beginnings, few of them to the end."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import ITERATIONS, Bench, Point, Refit, refit, within_columns
from fitting.diagnosis.release import settled
from fitting.diagnosis.screen import Promise
from fitting.diagnosis.wander import LEAST
from fitting.progress import Progress

STARTS = (0.7, 3.0)
"""Refits begin at these shares of the change that the linearised model expects; once more with another
shape."""
THIN = 3
"""Starts compete on one lane in so many, for `HEAT` steps."""
HEAT = 8
SETTLE = 3
HOPELESS = 2.0
"""A search that is not on its way to less than so many times the lowest cost is given up."""
FAR = 6.0


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
) -> list[Explanation]:
    """The best refits of the most successful promises, each on top of the effects that the base has.

    Several starts of every promise compete on a part of the lanes; the best starts of the best promises, so
    many as `finalists`, are fitted to all of them.
    """
    few = np.arange(0, len(bench.lanes), THIN)
    heat = bench.take(few)
    points, frees, owners = [], [], []
    for promise in promises:
        free = within_columns(base.free, model.of(promise.key))
        keys = model.together(base.point.keys, promise.key)
        begins = [(promise, share) for share in STARTS]
        if promise.second is not None:
            begins.append((promise.second, 1.0))
        for begin, share in begins:
            begun = _begin(model, base, begin, share, keys)
            points.append(dataclasses.replace(begun, own=begun.own[few]))
            frees.append(free)
            owners.append(promise)
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
    for promise, result in zip(owners, tried, strict=True):
        rival = heats.get(promise.key)
        if rival is None or result.misfit < rival[1].misfit:
            heats[promise.key] = promise, result
    final = sorted(heats.values(), key=lambda pair: pair[1].misfit)[:finalists]
    results = refit(
        model,
        bench,
        [_everywhere(model, bench, base, few, result.point) for _, result in final],
        [result.free for _, result in final],
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
    own = base.point.own.copy()
    own[few] = point.own
    part = dataclasses.replace(point, own=own[rest])
    own[rest], _ = settled(model, bench.take(rest), part, iterations=SETTLE)
    return dataclasses.replace(point, own=own)


def _begin(model: Model, base: Refit, promise: Promise, share: float, keys: tuple[str, ...]) -> Point:
    coordinates = base.point.coordinates.copy()
    strengths = model.index(*model.shelf.strengths[promise.key])
    change = np.clip(share * promise.change, -FAR, FAR)
    coordinates[strengths] = np.clip(change, model.lower[strengths], model.upper[strengths])
    if len(promise.shape):
        coordinates[model.index(*model.shelf.shapes[promise.key])] = promise.shape
    return dataclasses.replace(base.point, keys=keys, coordinates=coordinates)
