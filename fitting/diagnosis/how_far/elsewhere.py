"""Hypotheses on lanes that took no part in fitting them: constants and effects stay as they are, every lane's
start and what every run has of its own are found anew."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.centring import in_runs
from fitting.diagnosis.lanes.model import LEVEL_TOLERANCE, Model
from fitting.diagnosis.lanes.wander import LEAST
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import SUSPECT, all_settled, released

SETTLED = 8
"""Refits of starts and levels alone take so many steps at most."""


def elsewhere(
    model: Model, bench: Bench, points: Sequence[Point], frees: Sequence[np.ndarray] | None = None
) -> list[Refit]:
    """The points fitted to these lanes, from the starts that they have: at first every lane by itself, its
    friction as far off as a run's may be; then all lanes, with levels of friction and the free unknowns, if
    any, of every run. A lane that is lost under one of the points begins once more where another has it.
    """
    frees = [np.zeros(0, int)] * len(points) if frees is None else frees
    loose = np.array([LEVEL_TOLERANCE if bench.wanders else LEAST, LEAST])
    alone = all_settled(model, bench, [dataclasses.replace(point, widths=loose) for point in points])
    begin = [
        dataclasses.replace(in_runs(bench, each), widths=point.widths)
        for each, point in zip(alone, points, strict=True)
    ]
    fits = refit(model, bench, begin, frees, iterations=SETTLED, wander=False)
    return _begun_where_others_are(model, bench, fits, frees)


def _begun_where_others_are(
    model: Model, bench: Bench, fits: Sequence[Refit], frees: Sequence[np.ndarray]
) -> list[Refit]:
    """The refits, each fitted once more with the starts that the best of all has for lanes that it lost."""
    costs, own = (np.array(values) for values in ([f.cost for f in fits], [f.point.own for f in fits]))
    best, every = np.argmin(costs, axis=0), np.arange(costs.shape[1])
    lost = costs > SUSPECT * costs[best, every]
    out = list(fits)
    some = np.flatnonzero(lost.any(axis=1)).tolist()
    starts = [np.where(lost[number][:, None], own[best, every], own[number]) for number in some]
    begin = [dataclasses.replace(fits[n].point, own=start) for n, start in zip(some, starts, strict=True)]
    again = refit(model, bench, begin, [frees[n] for n in some], iterations=SETTLED, wander=False)
    for number, fit in zip(some, again, strict=True):
        out[number] = min(fits[number], fit, key=lambda one: one.misfit)
    return out


def in_place(model: Model, bench: Bench, point: Point, lanes: np.ndarray) -> Point:
    """A point for all lanes of a bench with what these `lanes`, and the runs that have no others, have of
    their own found anew, lost lanes freed."""
    some = bench.take(lanes)
    (fit,) = elsewhere(model, some, [point.take(lanes)])
    found = released(model, some, fit, wander=False).point
    by_run = point.by_run.copy()
    alone = np.setdiff1d(some.run, np.delete(bench.run, lanes))
    by_run[alone] = found.by_run[alone]
    return dataclasses.replace(found.among(point.own, lanes), by_run=by_run)
