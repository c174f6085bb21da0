"""The contest of starts: promises refitted from several beginnings, few of them to the end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.cost import misfit_of
from fitting.diagnosis.lanes.layout import strengths_of
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import LEAST
from fitting.diagnosis.refits.refit import ITERATIONS, Refit
from fitting.diagnosis.which.contained import lent
from fitting.diagnosis.which.explanation import Explanation, best_of
from fitting.diagnosis.which.finals import final
from fitting.diagnosis.which.heats import HEAT, heats
from fitting.diagnosis.which.screen import Promise
from fitting.diagnosis.which.starts import FROM_AFAR, Approach, Start, long_starts, own_at, start, starts_of
from fitting.progress import Progress, Silent

THIN = 3
"""Starts compete on one lane in so many."""


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
    starts = starts_of(model, bench, base, promises, few, approach)
    common = model.free_effects(base.free)
    progress.stage("pairs refitted" if common else "effects refitted", HEAT + ITERATIONS)
    moves = bool(np.any(base.point.widths > LEAST))
    if approach.long:
        early = long_starts(model, bench, base, promises, few)
        under_way = heats(model, heat, early, Silent(), wander=moves)
        starts += [Start(e.promise, e.keys, e.refit.point, e.refit.free) for e in under_way]
    tried = heats(model, heat, starts, progress, wander=moves)
    if approach.returns:
        stays = base.price(bench) * misfit_of(base.cost[few], heat.dof())
        null = base.point.take(few)
        astray = [start(model, base, e.promise, null) for e in best_of(tried) if e.refit.misfit > stays]
        tried += heats(model, heat, astray, Silent(), wander=moves)

    def own(found: Explanation) -> np.ndarray:
        return own_at(bench, base, found.promise, _share(model, bench, found))

    found = final(model, bench, own, few, tried, finalists, progress, wander=wander)
    return lent(model, bench, base, found) if common else found


def _share(model: Model, bench: Bench, found: Explanation) -> float:
    """The share of the change expected of an effect that was found."""
    change = found.promise.change
    strengths = strengths_of(model, bench, found.refit.point, found.promise.key)
    return float(strengths @ change / max(change @ change, 1e-300))
