"""The search for two effects that act together."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.judging.enough import hints, passes_for_noise
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import LEAST, OWN, START
from fitting.diagnosis.noise.repeatability import wanders
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.which.afresh import has_one_sign, outright
from fitting.diagnosis.which.contest import contest
from fitting.diagnosis.which.explanation import Explanation, best_of, fitted_again
from fitting.diagnosis.which.screen import Screen, Shapes, screen
from fitting.diagnosis.which.survey import FINALISTS, STRONG, freed, second_look
from fitting.progress import Progress

SECONDS, FINAL_PAIRS = 5, 3
"""So many effects are tried beside each of the `LEADERS`, and so many of these to the end."""
LEADERS = 2
INSTEAD = 3
WORTHWHILE = 0.95
"""So many effects are tried in the place of each of the two of the best pair, if this leaves less than such a
share of what one leaves."""
RIVAL = 2.0
"""Pairs are sought with the best effect, and with the second best where it leaves less than so many times as
much."""


def pairs_beside(
    model: Model,
    bench: Bench,
    found: Sequence[Explanation],
    around: Screen,
    floor: float,
    progress: Progress,
) -> list[Explanation]:
    """Two effects together, the best first: what promises most beside the best single effects (`around` is
    the screening beside the very best) and beside either of the best two, and what does in the place of
    either of these. Where no two leave what passes for noise above the `floor`, what has one sign is tried
    outright beside the best."""
    leader, led = found[0].refit, rivals(found)

    def beside(first: Explanation) -> list[Explanation]:
        seen = around if first is found[0] else screen(model, bench, first.refit, shapes=around.shapes)
        return contest(model, bench, first.refit, seen.ranked[:SECONDS], FINAL_PAIRS, progress)

    pairs = freed(model, bench, best_of([pair for first in led for pair in beside(first)]), LEADERS)
    if not passes_for_noise(pairs[0].refit.misfit / floor):
        tried = {frozenset(pair.keys) for pair in pairs}
        missed = [p for p in around.promises if frozenset({*found[0].keys, p.key}) not in tried]
        missed = [p for p in missed if has_one_sign(model, p)]
        more = outright(model, bench, leader, missed, FINAL_PAIRS, progress)
        pairs = freed(model, bench, best_of([*pairs, *more]), LEADERS)
    if pairs[0].refit.misfit >= WORTHWHILE * leader.misfit:
        return pairs
    known = {e.keys for e in led}
    hidden = [e for e in found if e.keys not in known and {*e.keys} < {*pairs[0].keys}]
    if hidden:
        more = [pair for first in hidden for pair in beside(first)]
        pairs = freed(model, bench, best_of([*pairs, *more]), LEADERS)
    return in_place_of_either(model, bench, pairs, INSTEAD, around.shapes, progress)


def rivals(found: Sequence[Explanation]) -> list[Explanation]:
    """The best explanation, and the next where it leaves nearly as little."""
    best = found[0]
    return [best, *(e for e in found[1:LEADERS] if e.refit.misfit < RIVAL * best.refit.misfit)]


def in_place_of_either(
    model: Model,
    bench: Bench,
    pairs: Sequence[Explanation],
    others: int,
    shapes: Shapes,
    progress: Progress,
) -> list[Explanation]:
    """The pairs, the best first, with those in which another effect stands in the place of either of the best
    two: an effect that leaves the same trace, or one of so many `others`. Where one of the two has given way,
    what leaves the same trace as the other is tried once more beside the new one."""

    def instead_of(key: str, found: Sequence[Explanation], others: int) -> list[Explanation]:
        return second_look(model, bench, found, key, others, shapes, progress)

    first = pairs[0].keys
    tried = [other for key in first for other in instead_of(key, pairs, others)]
    found = freed(model, bench, best_of([*pairs, *tried]), LEADERS)
    stayed = [key for key in first if key in found[0].keys]
    again = instead_of(stayed[0], found, 0) if len(stayed) == 1 else []
    return freed(model, bench, best_of([*found, *again]), LEADERS) if again else found


def with_still_friction(
    model: Model, bench: Bench, nominal: Refit, leader: Explanation, shapes: Shapes, progress: Progress
) -> list[Explanation]:
    """Explanations found from a nominal model whose friction may not wander: what changes from lane to lane
    with direction, place or time would else be taken for wandering, and refits that begin there stay there.

    Pairs are among them where friction wanders even under the leader, the best explanation so far, which may
    then owe to its wandering what a second effect does. Where the leader is two effects already, they are
    sought beside the best that acts alone.
    """
    begins = [_kept_still(fit.point) for fit in (nominal, leader.refit)]
    still, alone = refit(model, bench, begins, [nominal.free, leader.refit.free], wander=False)
    promises = screen(model, bench, still, shapes=shapes).ranked[:FINALISTS]
    found = contest(model, bench, still, promises, FINALISTS, progress, wander=False)
    found = best_of([*found, leader.fitted(alone)])
    best = next(e.refit for e in found if len(e.keys) == 1)
    if wanders(leader.refit) and hints(still.misfit, best.misfit):
        seconds = screen(model, bench, best, shapes=shapes).ranked[:SECONDS]
        found += contest(model, bench, best, seconds, FINAL_PAIRS, progress, wander=False)
    return fitted_again(model, bench, found)


def _kept_still(point: Point) -> Point:
    """The point with friction that neither wanders nor may."""
    own = point.own.copy()
    own[:, START:] = 0.0
    return dataclasses.replace(point, own=own, widths=np.full(OWN - START, LEAST))


def each_alone(
    model: Model, bench: Bench, found: Sequence[Explanation], pairs: Sequence[Explanation], seen: Screen
) -> list[Explanation]:
    """The effects of the best pairs, each by itself from where it stands beside the other, if the pair leaves
    far less than the effect was found to leave alone, or less at all than the best one: whatever came second
    may only have helped over a hill between the nominal model and what one effect explains."""
    alone = {e.keys[0]: e.refit.misfit for e in found if len(e.keys) == 1}
    promises = {promise.key: promise for promise in seen.promises}
    beside = {key: pair for pair in reversed(pairs[:LEADERS]) for key in pair.keys}
    dof = float(bench.dof().sum())

    def by_itself(key: str) -> Explanation:
        others = [other for other in beside[key].keys if other != key]
        bare = beside[key].refit.stripped(model, others)
        reached = alone.get(key, math.inf) * dof
        (again,) = refit(model, bench, [bare.point], [bare.free], hopeless=1.0, reached=reached)
        return Explanation((key,), promises[key], again)

    leader = min(alone, key=lambda key: alone[key])
    hidden = [
        key
        for key, pair in beside.items()
        if pair.refit.misfit < (1.0 if key == leader else STRONG) * alone.get(key, math.inf)
    ]
    tried = model.side_by_side(by_itself, hidden)
    better = [e for e in tried if e.refit.misfit < alone.get(e.keys[0], math.inf)]
    return freed(model, bench, better) if better else []
