"""Which effect: all of them screened, the promising ones refitted, alone and in pairs, and weighed."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.base import nuisances
from fitting.diagnosis.judge import Account, Judgement, judge, suffices
from fitting.diagnosis.model import COLUMNS, Model
from fitting.diagnosis.refit import Bench, Point, Refit, refit
from fitting.diagnosis.release import borrowed, released
from fitting.diagnosis.screen import Promise, Screen, screen
from fitting.progress import Progress

SHORT_LIST = 10
SHORTEST_LIST = 4
PROMISING = 15.0
"""Beyond the shortest list an effect is refitted only if its score is this many times what scores vary by."""
STARTS = (0.7, 3.0)
"""Refits begin at these shares of the change that the linearised model expects; once more with another
shape."""
SHORT_LIST_OF_SECONDS = 5
LEADERS = 2
RELEASED = 4
SAME = 0.9
"""Aliases are the same to records in which the cosine between their traces is larger."""
FAR = 6.0


@dataclasses.dataclass(frozen=True)
class Explanation:
    """One effect or several, refitted, with the promise that brought it on the short list."""

    keys: tuple[str, ...]
    promise: Promise
    refit: Refit


@dataclasses.dataclass(frozen=True)
class Attribution:
    """The nominal model's refit, the explanations (best first), the screenings that led to them, and the
    judgement."""

    nominal: Refit
    explanations: tuple[Explanation, ...]
    screen: Screen
    judgement: Judgement
    inflation: float


def attribute(model: Model, bench: Bench, point: Point, progress: Progress) -> Attribution:
    """Screens and refits every effect on a bench, beginning at the nominal model's point."""
    progress.stage("effects screened", 2)
    (nominal,) = refit(model, bench, [point], [nuisances(model)])
    nominal = released(model, bench, nominal)
    progress.advance(f"chi2 per sample {nominal.misfit:.4g}")
    first = screen(model, bench, nominal)
    progress.advance(f"{len(first.keys)} effects")
    found = _refitted(model, bench, nominal, _short_list(first.promises), progress)
    found.sort(key=lambda explanation: explanation.refit.misfit)
    found[:RELEASED] = [
        dataclasses.replace(e, refit=released(model, bench, e.refit)) for e in found[:RELEASED]
    ]
    found.sort(key=lambda explanation: explanation.refit.misfit)
    leader = found[0]
    nominal = borrowed(model, bench, nominal, leader.refit)
    found[1:RELEASED] = [
        dataclasses.replace(e, refit=borrowed(model, bench, e.refit, leader.refit)) for e in found[1:RELEASED]
    ]
    alone = suffices(nominal.misfit, leader.refit.misfit)
    around = screen(model, bench, leader.refit, own_group=alone, shapes=not alone)
    inflation = float(np.median([promise.inflation for promise in around.promises]))
    if not alone:
        screens = [around, *(screen(model, bench, other.refit) for other in found[1:LEADERS])]
        found += _pairs(model, bench, found[:LEADERS], screens, progress)
    found.sort(key=lambda explanation: explanation.refit.misfit)
    accounts = [
        Account(e.keys, e.refit.misfit, sum(len(model.shelf.names(key)) for key in e.keys)) for e in found
    ]
    judgement = judge(
        nominal.misfit,
        accounts,
        float(bench.dof().sum()),
        inflation,
        list(model.shelf.effects),
        _aliases(model, first),
    )
    return Attribution(nominal, tuple(found), first, judgement, inflation)


def _refitted(
    model: Model, bench: Bench, base: Refit, promises: Sequence[Promise], progress: Progress
) -> list[Explanation]:
    """The best refit of every promise, on top of the effects that the base has."""
    points, frees, owners = [], [], []
    for promise in promises:
        free = np.concatenate([base.free, model.of(promise.key)])[: COLUMNS - 1]
        keys = model.together(base.point.keys, promise.key)
        begins = [(promise, share) for share in STARTS]
        if promise.second is not None:
            begins.append((promise.second, 1.0))
        for begin, share in begins:
            points.append(_begin(model, base, begin, share, keys))
            frees.append(free)
            owners.append(promise)
    progress.stage("effects refitted" if len(base.free) == len(nuisances(model)) else "pairs refitted", 14)
    results = refit(model, bench, points, frees, progress=lambda: progress.advance())
    best: dict[str, Explanation] = {}
    for promise, result in zip(owners, results, strict=True):
        keys = (*model.free_effects(base.free), promise.key)
        rival = best.get(promise.key)
        if rival is None or result.misfit < rival.refit.misfit:
            best[promise.key] = Explanation(keys, promise, result)
    return list(best.values())


def _begin(model: Model, base: Refit, promise: Promise, share: float, keys: tuple[str, ...]) -> Point:
    coordinates = base.point.coordinates.copy()
    strengths = model.index(*model.shelf.strengths[promise.key])
    change = np.clip(share * promise.change, -FAR, FAR)
    coordinates[strengths] = np.clip(change, model.lower[strengths], model.upper[strengths])
    if len(promise.shape):
        coordinates[model.index(*model.shelf.shapes[promise.key])] = promise.shape
    return dataclasses.replace(base.point, keys=keys, coordinates=coordinates)


def _aliases(model: Model, seen: Screen) -> dict[str, list[str]]:
    """The effects that leave the same trace as another in these very records."""
    traces = [set(model.shelf.effects[key].traces) for key in seen.keys]
    return {
        key: [
            other
            for there, other in enumerate(seen.keys)
            if here != there and traces[here] & traces[there] and seen.cosine[here, there] > SAME
        ]
        for here, key in enumerate(seen.keys)
    }


def _short_list(promises: Sequence[Promise]) -> list[Promise]:
    """The promises that are worth a refit."""
    return [
        promise
        for place, promise in enumerate(promises[:SHORT_LIST])
        if place < SHORTEST_LIST or promise.score > PROMISING * max(promise.inflation, 1.0)
    ]


def _pairs(
    model: Model,
    bench: Bench,
    leaders: Sequence[Explanation],
    screens: Sequence[Screen],
    progress: Progress,
) -> list[Explanation]:
    """A second effect beside each of the leading ones, as the screens at these show."""
    out: list[Explanation] = []
    for leader, seen in zip(leaders, screens, strict=True):
        out += _refitted(model, bench, leader.refit, seen.promises[:SHORT_LIST_OF_SECONDS], progress)
    unique: dict[frozenset[str], Explanation] = {}
    for pair in out:
        rival = unique.get(frozenset(pair.keys))
        if rival is None or pair.refit.misfit < rival.refit.misfit:
            unique[frozenset(pair.keys)] = pair
    return list(unique.values())
