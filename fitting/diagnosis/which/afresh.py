"""Refits that begin elsewhere than where the nominal model ended, and than where its linearisation points."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.layout import strengths_of, with_strengths
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.refits.release import all_settled
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.finals import final
from fitting.diagnosis.which.heats import heats
from fitting.diagnosis.which.screen import Promise
from fitting.diagnosis.which.starts import start
from fitting.progress import Progress, Silent

HEAT_LANES = 16
"""Starts compete on so many lanes at most, spread evenly."""
OUTRIGHT = (3.0, 15.0)
"""Sizes at which effects begin that are tried outright, as multiples of typical ones."""


def afresh(
    model: Model,
    bench: Bench,
    nominal: Refit,
    begins: np.ndarray,
    promises: Sequence[Promise],
    finalists: int,
    progress: Progress,
) -> list[Explanation]:
    """The promises of the nominal model refitted, the best of them to the end, each from null and from all of
    the constants (coordinates) in `begins`.

    Where no friction force was recorded, the motion alone tells the constants, and the lack of a strong
    effect may lead them so far astray that hardly any effect is of help there.
    """
    few = bench.spread(HEAT_LANES)
    heat = bench.take(few)
    own = np.asarray(heat.lanes.start)
    origin = dataclasses.replace(nominal.point, coordinates=model.origin({}), own=own)
    points = all_settled(model, heat, [origin.at_constants(model, constants) for constants in begins])
    seen = [promise for promise in promises if promise.can_be_seen]
    progress.stage("effects refitted afresh", len(seen))
    tried = []
    for promise in seen:
        starts = [start(model, nominal, promise, point) for point in points]
        tried += heats(model, heat, starts, Silent(), wander=False)
        progress.advance(promise.key)
    recorded = np.asarray(bench.lanes.start)
    return final(model, bench, lambda _: recorded, few, tried, finalists, Silent())


def has_one_sign(model: Model, promise: Promise) -> bool:
    """Whether the strengths of a promised effect cannot be negative."""
    return not model.two_sided(model.index(*model.shelf.strengths[promise.key])).any()


def outright(
    model: Model,
    bench: Bench,
    nominal: Refit,
    promises: Sequence[Promise],
    finalists: int,
    progress: Progress,
) -> list[Explanation]:
    """The promises of the nominal model refitted, the best of them to the end, from sizes that are no longer
    small, of either sign where they may have it: play, a stop or a clipped peak does next to nothing at null,
    and the lack of a strong effect may have led the nominal model where none is of help."""
    promises = [promise for promise in promises if promise.can_be_seen or model.may_show(promise.key)]
    few = bench.spread(HEAT_LANES)
    heat, bare = bench.take(few), nominal.point.take(few)
    progress.stage("effects refitted outright", 1)

    def at(promise: Promise, size: float) -> Point:
        strengths = np.full_like(strengths_of(model, bench, bare, promise.key), size)
        begun = start(model, nominal, promise, with_strengths(model, bench, bare, promise.key, strengths))
        within = np.clip(begun.point.coordinates, model.lower, model.upper)
        return dataclasses.replace(begun.point, coordinates=within)

    def sizes(promise: Promise) -> tuple[float, ...]:
        return OUTRIGHT if has_one_sign(model, promise) else (*OUTRIGHT, *(-size for size in OUTRIGHT))

    begun = [(promise, at(promise, size)) for promise in promises for size in sizes(promise)]
    points = all_settled(model, heat, [point for _, point in begun])
    starts = [start(model, nominal, p, point) for (p, _), point in zip(begun, points, strict=True)]
    tried = heats(model, heat, starts, Silent(), wander=False)
    progress.advance()
    return final(model, bench, lambda _: nominal.point.own, few, tried, finalists, Silent())
