"""Refits: several hypotheses fitted side by side to the same lanes, every lane's start and every run's level
of friction free, and the friction of every lane as far as it wanders."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.cost import misfit_of
from fitting.diagnosis.lanes.model import Job, Model
from fitting.diagnosis.lanes.steadiness import Levels
from fitting.diagnosis.lanes.wander import allowed
from fitting.diagnosis.refits.search import Search

ITERATIONS = 30
PATIENCE = 8.0
LEAST_TURNS = 4


@dataclasses.dataclass(frozen=True)
class Refit:
    """Where a refit ended: the point, the cost of every lane (data, and what its friction's wandering costs),
    the misfit, and each lane's weight. `free` are the unknowns that were fitted.

    misfit: chi-square per degree of freedom with outliers weighed down, times what the freedom of friction to
    wander costs in likelihood, exp(sum log(1 + width^2 information)/N). `levels` are those of friction. told:
    how many times as much as its prior the records say of each unknown, by its number, that was free.
    """

    point: Point
    free: np.ndarray
    cost: np.ndarray
    misfit: float
    weights: np.ndarray
    iterations: int
    levels: Levels
    told: Mapping[int, float]
    freed: bool = False

    def price(self, bench: Bench) -> float:
        """By what factor the misfit is larger for the freedom of friction to wander."""
        return self.misfit / misfit_of(self.cost, bench.dof())

    def typical(self, bench: Bench) -> float:
        """What it leaves of a typical lane, as a misfit."""
        return self.price(bench) * float(np.median(self.cost / bench.dof()))

    def showing(self, model: Model, wanted: Collection[str]) -> Refit:
        """The same, with attached what shows what these effects would do beside its own."""
        attached = model.sharing.seen(wanted, model.free_effects(self.free))
        return dataclasses.replace(self, point=dataclasses.replace(self.point, keys=attached))

    def stripped(self, model: Model, keys: Sequence[str]) -> Refit:
        """Where a refit without some of its effects begins: these at null and not free. Costs and misfit are
        still those with them."""
        free = self.free[~np.isin(self.free, np.concatenate([model.of(key) for key in keys]))]
        attached = model.sharing.fitted(model.free_effects(free))
        point = dataclasses.replace(self.point.without(model, keys), keys=attached)
        return self.begun(point, free)

    def begun(self, point: Point, free: np.ndarray) -> Refit:
        """Where another refit begins, at a point and with what is free then. Costs and misfit are still those
        of this one."""
        return dataclasses.replace(self, point=point, free=free, freed=False)


def refit(
    model: Model,
    bench: Bench,
    points: Sequence[Point],
    frees: Sequence[np.ndarray],
    *,
    iterations: int = ITERATIONS,
    wander: bool = True,
    hopeless: float = math.inf,
    reached: float = math.inf,
    enough: float | None = None,
    progress: Callable[[], None] = lambda: None,
) -> list[Refit]:
    """Levenberg-Marquardt from each point over its own free unknowns, all searches in common passes. A search
    is over when it gains less than the share `enough` of its cost, by default as much as a verdict asks for.
    Where not `wander`, the points' widths stay as they are. A search is given up where it would still cost
    `hopeless` times the lowest cost, or one that has been `reached` elsewhere, after `PATIENCE` more steps as
    good as its last."""
    searches = [
        Search(model, bench, point, free, wander, enough) for point, free in zip(points, frees, strict=True)
    ]
    _evaluate(model, bench, searches, [search.point for search in searches], first=True)
    for turn in range(iterations):
        under_way = [search for search in searches if not search.over]
        led = model.side_by_side(lambda search: search.step(), under_way)
        steps = [(search, point) for search, point in zip(under_way, led, strict=True) if not search.over]
        if not steps:
            break
        going, points = map(list, zip(*steps, strict=True))
        _evaluate(model, bench, going, points, first=False)
        lowest = min(reached, *(search.cost for search in searches))
        for search in going if turn >= LEAST_TURNS else ():
            search.over |= search.cost - PATIENCE * search.gain > hopeless * lowest
        progress()
    return [_ended(search) for search in searches]


def _ended(search: Search) -> Refit:
    return Refit(
        search.point,
        search.free,
        search.data,
        search.misfit,
        search.weights,
        search.taken,
        search.levels,
        search.told(),
    )


def _evaluate(
    model: Model, bench: Bench, searches: Sequence[Search], points: Sequence[Point], *, first: bool
) -> None:
    """Lets every search see its point; those with the same effects, and as many derivatives, share packs."""
    together: dict[tuple[tuple[str, ...], int], list[int]] = {}
    for number, (search, point) in enumerate(zip(searches, points, strict=True)):
        together.setdefault((point.attached, search.chosen.shape[1]), []).append(number)
    count = len(bench.lanes)
    jobs = [
        Job(
            keys,
            bench.lanes,
            np.concatenate([allowed(bench.lanes, points[n].widths) for n in numbers]),
            np.concatenate([points[n].each(model, bench) for n in numbers]),
            np.concatenate([points[n].own for n in numbers]),
            np.concatenate([searches[n].chosen for n in numbers]),
            bench.whitener,
        )
        for (keys, _), numbers in together.items()
    ]
    seen = {
        number: columns.part(slice(place * count, (place + 1) * count))
        for numbers, columns in zip(together.values(), model.columns(jobs), strict=True)
        for place, number in enumerate(numbers)
    }
    model.side_by_side(lambda number: searches[number].see(points[number], seen[number], first), seen)
