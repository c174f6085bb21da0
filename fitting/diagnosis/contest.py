"""The contest of starts: promises refitted from several beginnings, few of them to the end."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.bench import Bench, Point
from fitting.diagnosis.layout import Layout, strengths_of, with_strengths
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import ITERATIONS, Refit, misfit_of, refit, within_columns
from fitting.diagnosis.release import all_settled, released, settled
from fitting.diagnosis.screen import Promise
from fitting.diagnosis.wander import LEAST, START
from fitting.progress import Progress, Silent

THIN = 3
"""Starts compete on one lane in so many, for `HEAT` steps."""
HEAT = 8
SETTLE = 3
HOPELESS = 2.0
"""A search that is not on its way to less than so many times the lowest cost is given up."""
HIDDEN, NOTABLY = 2, 0.97
"""So many more go to the end that leave less of a typical lane, by this factor, though more of all."""
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

    def begun(promise: Promise, begin: Promise, share: float, far: float) -> Start:
        return start(model, base, promise, _begin(model, bench, base, begin, share, far).take(few))

    starts = []
    for promise in promises:
        starts += [begun(promise, promise, share, approach.far) for share in approach.shares]
        if promise.second is not None:
            starts.append(begun(promise, promise.second, 1.0, approach.far))
    if approach.settle:
        points = all_settled(model, heat, [each.point for each in starts])
        starts = [each._replace(point=point) for each, point in zip(starts, points, strict=True)]
    common = model.free_effects(base.free)
    progress.stage("pairs refitted" if common else "effects refitted", HEAT + ITERATIONS)
    moves = bool(np.any(base.point.widths > LEAST))
    lasting = [promise for promise in promises if approach.long and model.lasts(promise.key)]
    if lasting:
        early = [begun(promise, _long(model, promise), 1.0, LONG) for promise in lasting]
        under_way = heats(model, heat, early, Silent(), wander=moves)
        starts += [Start(e.promise, e.keys, e.refit.point, e.refit.free) for e in under_way]
    tried = heats(model, heat, starts, progress, wander=moves)
    if approach.returns:
        stays = base.price(bench) * misfit_of(base.cost[few], heat.dof())
        null = base.point.take(few)
        astray = [start(model, base, e.promise, null) for e in best_of(tried) if e.refit.misfit > stays]
        tried += heats(model, heat, astray, Silent(), wander=moves)

    def own(found: Explanation) -> np.ndarray:
        return _own(bench, base, found.promise, _share(model, bench, found))

    return final(model, bench, own, few, tried, finalists, progress, wander=wander)


class Start(NamedTuple):
    """Where a refit of a promise begins, on some lanes, and what is then free."""

    promise: Promise
    keys: tuple[str, ...]
    point: Point
    free: np.ndarray


def start(model: Model, base: Refit, promise: Promise, point: Point) -> Start:
    """A start of a promise on top of the effects that the base has, at a point of the base's lanes."""
    keys = *model.free_effects(base.free), promise.key
    point = dataclasses.replace(point, keys=model.together(base.point.keys, promise.key))
    return Start(promise, keys, point, within_columns(model, base.free, model.of(promise.key)))


def heats(
    model: Model, heat: Bench, starts: Sequence[Start], progress: Progress, *, wander: bool
) -> list[Explanation]:
    """All starts fitted for `HEAT` steps to a part of the lanes."""
    points, frees = [each.point for each in starts], [each.free for each in starts]
    tried = refit(
        model, heat, points, frees, iterations=HEAT, wander=wander, progress=lambda: progress.advance()
    )
    return [Explanation(s.keys, s.promise, fit) for s, fit in zip(starts, tried, strict=True)]


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
    best = sorted(best_of(tried), key=lambda e: e.refit.misfit)[:finalists]
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
    return best_of([dataclasses.replace(e, refit=fit) for e, fit in zip(chosen, fits, strict=True)])


def hidden_by_lost_lanes(
    heat: Bench, tried: Sequence[Explanation], best: Sequence[Explanation]
) -> Sequence[Explanation]:
    """Those that a few lost lanes hide: what leaves less of a typical lane than any of the best."""

    def typical(e: Explanation) -> float:
        return e.refit.typical(heat)

    least = min(map(typical, best), default=0.0)
    less = sorted((e for e in tried if typical(e) < NOTABLY * least), key=typical)
    first = {e.keys: e for e in reversed(less)}
    return sorted(first.values(), key=typical)[:HIDDEN]


def best_of(explanations: Sequence[Explanation]) -> list[Explanation]:
    """Of explanations by the same effects the one with the lowest misfit."""
    best: dict[frozenset[str], Explanation] = {}
    for one in explanations:
        rival = best.get(frozenset(one.keys))
        if rival is None or one.refit.misfit < rival.refit.misfit:
            best[frozenset(one.keys)] = one
    return list(best.values())


def _everywhere(model: Model, bench: Bench, own: np.ndarray, few: np.ndarray, point: Point) -> Point:
    """A point found on few lanes for all of them: the others' `own` settled at its unknowns."""
    rest = np.setdiff1d(np.arange(len(bench.lanes)), few)
    whole = point.among(own, few)
    if not len(rest):
        return whole
    found, _ = settled(model, bench.take(rest), whole.take(rest), iterations=SETTLE)
    return dataclasses.replace(point, own=found).among(whole.own, rest)


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
    own = _own(bench, base, promise, share)
    return dataclasses.replace(point, coordinates=coordinates, by_run=by_run, own=own)


def _long(model: Model, promise: Promise) -> Promise:
    """The promise of a long time, for which nothing makes room beforehand, of a sign that it may have."""
    two_sided = model.lower[model.index(*model.shelf.strengths[promise.key])] < 0
    change = np.where(two_sided, np.copysign(LONG, promise.change), LONG)
    still = {name: np.zeros_like(getattr(promise, name)) for name in ("room", "own_room")}
    return dataclasses.replace(promise, change=change, **still)


def _own(bench: Bench, base: Refit, promise: Promise, share: float) -> np.ndarray:
    """What lanes have of their own at this share of the expected change."""
    reach = OWN_REACH * np.asarray(bench.lanes.start_deviation)
    reach[:, START:] = FRICTION_REACH
    return base.point.own + np.clip(promise.own_around + share * promise.own_room, -reach, reach)


def _share(model: Model, bench: Bench, found: Explanation) -> float:
    """The share of the change expected of an effect that was found."""
    change = found.promise.change
    strengths = strengths_of(model, bench, found.refit.point, found.promise.key)
    return float(strengths @ change / max(change @ change, 1e-300))
