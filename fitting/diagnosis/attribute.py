"""Which effect: all of them screened, the promising ones refitted, alone and in pairs, and weighed."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from fitting.diagnosis.base import nuisances
from fitting.diagnosis.judge import Account, Judgement, judge, suffices
from fitting.diagnosis.model import COLUMNS, Model
from fitting.diagnosis.refit import Bench, Point, Refit, refit
from fitting.diagnosis.release import borrowed, released, settled
from fitting.diagnosis.repeatability import unrepeated
from fitting.diagnosis.screen import Promise, Screen, Shapes, screen
from fitting.diagnosis.wander import LEAST, OWN, START
from fitting.progress import Progress

SHORT_LIST = 10
SHORTEST_LIST = 4
PROMISING = 15.0
"""Beyond the shortest list an effect is refitted only if its score is this many times what scores vary by."""
STARTS = (0.7, 3.0)
"""Refits begin at these shares of the change that the linearised model expects; once more with another
shape."""
THIN = 3
"""Starts compete on one lane in so many, with coarser steps, for `HEAT` steps."""
HEAT = 8
FINALISTS, PAIR_FINALISTS = 6, 3
"""So many effects, each from its best start, are then fitted to all lanes; so many as the second of a pair.
"""
SETTLE = 3
HOPELESS = 2.0
"""A search that is not on its way to less than so many times the lowest cost is given up."""
SHORT_LIST_OF_SECONDS = 5
LEADERS = 2
RIVAL = 2.0
"""Pairs are sought with the best effect, and with the second best where it leaves less than so many times as
much."""
A_GOOD_DEAL = 0.002
"""Friction that wanders by less, as a share of itself, hides nothing."""
RELEASED = 4
REACH = 4.0
"""Lost lanes are looked after where the misfit is less than so many times the lowest."""
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
    """The nominal model's refit, the explanations (best first), the screening that led to them, the
    judgement; by how much scores vary more than white noise, and the misfit that no model can get below, for
    it does not repeat itself from cycle to cycle."""

    nominal: Refit
    explanations: tuple[Explanation, ...]
    screen: Screen
    judgement: Judgement
    inflation: float
    floor: float


@dataclasses.dataclass(frozen=True)
class Survey:
    """The nominal model's refit, the screening there, single effects refitted (best first), and the misfit
    that no model gets below."""

    nominal: Refit
    screen: Screen
    found: tuple[Explanation, ...]
    floor: float

    @property
    def suffices(self) -> bool:
        """Whether one effect, or none, leaves next to nothing."""
        return suffices(self.nominal.misfit / self.floor, self.found[0].refit.misfit / self.floor)


def survey(model: Model, bench: Bench, point: Point, progress: Progress) -> Survey:
    """Screens every effect on a bench, from the nominal model's point on, and refits the promising ones."""
    progress.stage("effects screened", 2)
    (nominal,) = refit(model, bench, [point], [nuisances(model)])
    nominal = released(model, bench, nominal)
    progress.advance(f"chi2 per sample {nominal.misfit:.4g}")
    first = screen(model, bench, nominal)
    progress.advance(f"{len(first.keys)} effects")
    promises = _short_list(first.promises)
    found = _freed(model, bench, _refitted(model, bench, nominal, promises, progress))
    floor = unrepeated(model, bench, [nominal, found[0].refit])
    return Survey(nominal, first, tuple(found), floor)


def attribute(model: Model, bench: Bench, seen: Survey, progress: Progress) -> Attribution:
    """Looks for pairs where no single effect suffices, and weighs all explanations."""
    nominal, first, found, floor = seen.nominal, seen.screen, list(seen.found), seen.floor
    if _wanders(nominal) and not seen.suffices:
        still = _with_still_friction(model, bench, nominal, first.shapes, progress)
        found = _freed(model, bench, _best_of([*found, *still]))
    leader = found[0]
    nominal = borrowed(model, bench, nominal, leader.refit)
    floor = min(floor, unrepeated(model, bench, [nominal, leader.refit]))
    alone = suffices(nominal.misfit / floor, leader.refit.misfit / floor)
    around = screen(model, bench, leader.refit, own_group=alone, shapes=[] if alone else first.shapes)
    inflation = float(np.median([promise.inflation for promise in around.promises]))
    if not alone:
        seconds = [e for e in found[1:LEADERS] if e.refit.misfit < RIVAL * leader.refit.misfit]
        screens = [around, *(screen(model, bench, e.refit, shapes=first.shapes) for e in seconds)]
        pairs = [
            pair
            for base, seen in zip(found, screens, strict=False)
            for pair in _refitted(model, bench, base.refit, seen.promises[:SHORT_LIST_OF_SECONDS], progress)
        ]
        found += _best_of(pairs)
    found.sort(key=lambda explanation: explanation.refit.misfit)
    floor = min(floor, unrepeated(model, bench, [found[0].refit]))
    accounts = [
        Account(e.keys, e.refit.misfit / floor, sum(len(model.shelf.names(key)) for key in e.keys))
        for e in found
    ]
    judgement = judge(
        nominal.misfit / floor,
        accounts,
        float(bench.dof().sum()),
        inflation,
        list(model.shelf.effects),
        _aliases(model, first),
    )
    return Attribution(nominal, tuple(found), first, judgement, inflation, floor)


def _refitted(
    model: Model, bench: Bench, base: Refit, promises: Sequence[Promise], progress: Progress
) -> list[Explanation]:
    """The best refit of every promise, on top of the effects that the base has."""
    few = np.arange(0, len(bench.lanes), THIN)
    heat = bench.take(few).coarser()
    points, frees, owners = [], [], []
    for promise in promises:
        free = np.concatenate([base.free, model.of(promise.key)])[: COLUMNS - 1]
        keys = model.together(base.point.keys, promise.key)
        begins = [(promise, share) for share in STARTS]
        if promise.second is not None:
            begins.append((promise.second, 1.0))
        for begin, share in begins:
            begun = _begin(model, base, begin, share, keys)
            points.append(dataclasses.replace(begun, own=begun.own[few]))
            frees.append(free)
            owners.append(promise)
    progress.stage("effects refitted" if len(base.free) == len(nuisances(model)) else "pairs refitted", 14)
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
    most = FINALISTS if len(base.free) == len(nuisances(model)) else PAIR_FINALISTS
    final = sorted(heats.values(), key=lambda pair: pair[1].misfit)[:most]
    results = refit(
        model,
        bench,
        [_everywhere(model, bench, base, few, result.point) for _, result in final],
        [result.free for _, result in final],
        hopeless=HOPELESS,
        progress=lambda: progress.advance(),
    )
    common = model.free_effects(base.free)
    return [
        Explanation((*common, promise.key), promise, result)
        for (promise, _), result in zip(final, results, strict=True)
    ]


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


def _best_of(explanations: Sequence[Explanation]) -> list[Explanation]:
    """Of explanations by the same effects the one with the lowest misfit."""
    best: dict[frozenset[str], Explanation] = {}
    for one in explanations:
        rival = best.get(frozenset(one.keys))
        if rival is None or one.refit.misfit < rival.refit.misfit:
            best[frozenset(one.keys)] = one
    return list(best.values())


def _freed(model: Model, bench: Bench, explanations: Sequence[Explanation]) -> list[Explanation]:
    """The explanations, the best first; of the leading ones lost lanes are freed, and they borrow from the
    best."""

    def sifted(found: Sequence[Explanation], again: Callable[[Explanation], Refit]) -> list[Explanation]:
        found = sorted(found, key=lambda e: e.refit.misfit)
        within = REACH * found[0].refit.misfit
        return [
            dataclasses.replace(e, refit=again(e)) if place < RELEASED and e.refit.misfit < within else e
            for place, e in enumerate(found)
        ]

    found = sifted(explanations, lambda e: released(model, bench, e.refit))
    leader = min((e.refit for e in found), key=lambda refit: refit.misfit)
    found = sifted(found, lambda e: borrowed(model, bench, e.refit, leader))
    return sorted(found, key=lambda e: e.refit.misfit)


def _wanders(fit: Refit) -> bool:
    """Whether a hypothesis lets friction wander by a good deal."""
    return float(fit.point.widths.max()) * math.sqrt(fit.misfit) > A_GOOD_DEAL


def _with_still_friction(
    model: Model, bench: Bench, nominal: Refit, shapes: Shapes, progress: Progress
) -> list[Explanation]:
    """Explanations found from a nominal model whose friction may not wander: what changes from lane to lane
    with direction, place or time would else be taken for wandering, and refits that begin there stay there.
    """
    own = nominal.point.own.copy()
    own[:, START:] = 0.0
    point = dataclasses.replace(nominal.point, own=own, widths=np.full(OWN - START, LEAST))
    (still,) = refit(model, bench, [point], [nominal.free], wander=False)
    promises = screen(model, bench, still, shapes=shapes).promises[:FINALISTS]
    return _refitted(model, bench, still, promises, progress)
