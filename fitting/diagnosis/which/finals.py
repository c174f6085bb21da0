"""What did best on few lanes, fitted to all of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import refit
from fitting.diagnosis.refits.release import released, settled
from fitting.diagnosis.which.explanation import Explanation, best_of
from fitting.progress import Progress

SETTLE = 3
HOPELESS = 2.0
"""A search that is not on its way to less than so many times the lowest cost is given up."""
HIDDEN, NOTABLY = 2, 0.97
"""So many more go to the end that leave less of a typical lane, by this factor, though more of all,"""
HARDLY_MORE, LOST = 1.1, 1.5
"""or hardly more than the least, by this factor, where all lanes leave so many times as much as a typical
one."""


def final(
    model: Model,
    bench: Bench,
    own: Callable[[Explanation], np.ndarray],
    few: np.ndarray,
    tried: Sequence[Explanation],
    finalists: int,
    progress: Progress,
    *,
    wander: bool = True,
) -> list[Explanation]:
    """The best of what was tried on few lanes fitted to all of them; what the others have of their own
    settles from where `own` (lanes, 5) puts it. Beside the best, so many as `finalists`, up to `HIDDEN` are
    that leave less of a typical lane than any of these; their lost lanes are then freed."""
    best = best_of(tried)[:finalists]
    hidden = hidden_by_lost_lanes(bench.take(few), tried, best)
    chosen = [*best, *hidden]
    fits = refit(
        model,
        bench,
        model.side_by_side(lambda e: _everywhere(model, bench, own(e), few, e.refit.point), chosen),
        [e.refit.free for e in chosen],
        wander=wander,
        hopeless=HOPELESS,
        progress=lambda: progress.advance(),
    )
    lost = fits[len(best) :]
    fits[len(best) :] = model.side_by_side(lambda fit: released(model, bench, fit, wander=wander), lost)
    return best_of([e.fitted(fit) for e, fit in zip(chosen, fits, strict=True)])


def hidden_by_lost_lanes(
    heat: Bench, tried: Sequence[Explanation], best: Sequence[Explanation]
) -> Sequence[Explanation]:
    """Those that a few lost lanes hide: what leaves less of a typical lane than any of the best, or is
    another effect, as good in such a lane, that has lost some."""

    def typical(e: Explanation) -> float:
        return e.refit.typical(heat)

    def hidden(e: Explanation) -> bool:
        of_lane = typical(e)
        lost = e.keys not in known and e.refit.misfit > LOST * of_lane
        return of_lane < NOTABLY * least or (lost and of_lane < HARDLY_MORE * least)

    least, known = min(map(typical, best), default=0.0), {e.keys for e in best}
    less = sorted((e for e in tried if hidden(e)), key=typical)
    first = {e.keys: e for e in reversed(less)}
    return sorted(first.values(), key=typical)[:HIDDEN]


def _everywhere(model: Model, bench: Bench, own: np.ndarray, few: np.ndarray, point: Point) -> Point:
    """A point found on few lanes for all of them: the others' `own` settled at its unknowns."""
    rest = np.setdiff1d(np.arange(len(bench.lanes)), few)
    whole = point.among(own, few)
    if not len(rest):
        return whole
    found = settled(model, bench.take(rest), whole.take(rest), iterations=SETTLE)
    return dataclasses.replace(point, own=found.own).among(whole.own, rest)
