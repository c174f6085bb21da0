"""Refits: several hypotheses fitted side by side to the same lanes, every lane's start and every run's level
of friction free, and the friction of every lane as far as it wanders."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.model import LEVEL_TOLERANCE, Columns, Job, Model
from fitting.diagnosis.programs import COLUMNS
from fitting.diagnosis.wander import OWN, START, allowed, likeliest
from fitting.lanes import Lanes
from fitting.newton import Robust, bounded_step

ITERATIONS = 30
ENOUGH = 2e-4
STUCK = 1e7
PATIENCE = 8.0
LEAST_TURNS = 4
GAUGE = 1e-4
BROKEN = 1e30
"""What a lane costs whose motion is no number, as with parameters that no rig has."""


@dataclasses.dataclass(frozen=True)
class Bench:
    """The lanes that hypotheses are judged on, which run each belongs to (0 .. runs - 1), and how many runs
    the data set has, of which some may have no lane here.

    phase: a number for every lane, the same for lanes that begin at the same phase of the excitation in
    cycles of the same run, -1 where no other does; wanders: whether friction may differ from lane to lane.
    """

    lanes: Lanes
    run: np.ndarray
    runs: int
    phase: np.ndarray
    wanders: bool

    def dof(self) -> np.ndarray:
        """Residuals of every lane that count, less the three of its start."""
        return self.lanes.counted() - 3

    def take(self, index: np.ndarray) -> Bench:
        """The bench with some of the lanes; runs keep their numbers."""
        return Bench(self.lanes.take(index), self.run[index], self.runs, self.phase[index], self.wanders)

    def coarser(self) -> Bench:
        """The bench with half as many integration steps a sample."""
        steps = max(1, math.ceil(self.lanes.substeps / 2))
        return dataclasses.replace(self, lanes=dataclasses.replace(self.lanes, substeps=steps))


@dataclasses.dataclass(frozen=True)
class Point:
    """A hypothesis at work: the effects attached, coordinates of all unknowns but the level, level of every
    run, what every lane has of its own (lanes, 5: start, level and slope of friction), and the standard
    deviations of those levels and slopes."""

    keys: tuple[str, ...]
    coordinates: np.ndarray
    levels: np.ndarray
    own: np.ndarray
    widths: np.ndarray

    def each(self, bench: Bench) -> np.ndarray:
        """Coordinates of every lane, its run's level the last."""
        each = np.tile(self.coordinates, (len(bench.lanes), 1))
        each[:, -1] = self.levels[bench.run]
        return each


@dataclasses.dataclass(frozen=True)
class Refit:
    """Where a refit ended: the point, the cost of every lane (data, and what its friction's wandering costs),
    the misfit, and each lane's weight. `free` are the unknowns that were fitted.

    misfit: chi-square per degree of freedom with outliers weighed down, times what the freedom of friction to
    wander costs in likelihood, exp(sum log(1 + width^2 information)/N).
    """

    point: Point
    free: np.ndarray
    cost: np.ndarray
    misfit: float
    weights: np.ndarray
    iterations: int

    def price(self, bench: Bench) -> float:
        """By what factor the misfit is larger for the freedom of friction to wander."""
        return self.misfit / misfit_of(self.cost, bench.dof())

    def stripped(self, model: Model, keys: Sequence[str], stays: Sequence[str]) -> Refit:
        """Where a refit without some of its effects begins, those that stay being these: the others at null
        and not free. Costs and misfit are still those with them."""
        coordinates = model.without(self.point.coordinates, keys)
        point = dataclasses.replace(self.point, keys=model.together(stays), coordinates=coordinates)
        gone = np.concatenate([model.of(key) for key in keys])
        return dataclasses.replace(self, point=point, free=self.free[~np.isin(self.free, gone)])


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
    progress: Callable[[], None] = lambda: None,
) -> list[Refit]:
    """Levenberg-Marquardt from each point over its own free unknowns, all searches in common passes.
    Where not `wander`, the points' widths stay as they are. A search is given up where it would still cost
    `hopeless` times the lowest cost, or one that has been `reached` elsewhere, after `PATIENCE` more steps as
    good as its last."""
    searches = [_Search(model, bench, point, free, wander) for point, free in zip(points, frees, strict=True)]
    _evaluate(model, bench, searches, [search.point for search in searches], first=True)
    for turn in range(iterations):
        going = [search for search in searches if not search.over]
        if not going:
            break
        _evaluate(model, bench, going, [search.step() for search in going], first=False)
        lowest = min(reached, *(search.cost for search in searches))
        for search in going if turn >= LEAST_TURNS else ():
            search.over |= search.cost - PATIENCE * search.gain > hopeless * lowest
        progress()
    return [search.result() for search in searches]


def misfit_of(cost: np.ndarray, dof: np.ndarray) -> float:
    """Chi-square per degree of freedom; of lanes far above the typical one, what Huber leaves of them."""
    return Robust.around(cost, dof).total(cost) / float(dof.sum())


def whole_cost(columns: Columns) -> np.ndarray:
    """The cost of every lane with the prior of its start."""
    return _finite(np.einsum("lr,lr->l", columns.residual, columns.residual))


def data_cost(columns: Columns) -> np.ndarray:
    """The cost of every lane without the prior of its start."""
    squares = columns.residual**2
    return _finite(squares[:, :-OWN].sum(1) + squares[:, START - OWN :].sum(1))


def _finite(cost: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(cost), cost, BROKEN)


def normal(columns: Columns) -> tuple[np.ndarray, np.ndarray]:
    """J'r and J'J of every lane, what it has of its own last; no pull at all of a lane where they are no
    numbers."""
    jacobian = columns.jacobian
    gradient = np.einsum("lrc,lr->lc", jacobian, columns.residual)
    curvature = jacobian.transpose(0, 2, 1) @ jacobian
    broken = ~(np.isfinite(gradient).all(1) & np.isfinite(curvature).all((1, 2)))
    gradient[broken], curvature[broken] = 0.0, np.eye(gradient.shape[1])
    return gradient, curvature


class Projection:
    """Takes out of values (lanes, rows, ..) what each lane can make of them by itself."""

    def __init__(self, columns: Columns) -> None:
        self._basis, _ = np.linalg.qr(columns.jacobian[:, :, COLUMNS:])

    def __call__(self, values: np.ndarray) -> np.ndarray:
        return values - self._basis @ (self._basis.transpose(0, 2, 1) @ values)


def chosen_columns(free: np.ndarray, level: int, lanes: int) -> np.ndarray:
    """What the program differentiates by: the level of friction first, then the free unknowns."""
    row = np.full(COLUMNS, -1)
    row[0] = level
    row[1 : 1 + len(free)] = free
    return np.tile(row, (lanes, 1))


def within_columns(*unknowns: np.ndarray) -> np.ndarray:
    """Unknowns that are to be free, as many as the program has columns for beside the level of friction."""
    return np.concatenate(unknowns)[: COLUMNS - 1]


def job(bench: Bench, point: Point, chosen: np.ndarray | None = None) -> Job:
    """The linearisation of a bench at a point, by what each lane has of its own and the chosen unknowns."""
    if chosen is None:
        chosen = np.full((len(bench.lanes), COLUMNS), -1)
    return Job(point.keys, allowed(bench.lanes, point.widths), point.each(bench), point.own, chosen)


def _evaluate(
    model: Model, bench: Bench, searches: Sequence[_Search], points: Sequence[Point], *, first: bool
) -> None:
    """Lets every search see its point; searches with the same effects share their packs."""
    together: dict[tuple[str, ...], list[int]] = {}
    for number, point in enumerate(points):
        together.setdefault(point.keys, []).append(number)
    count = len(bench.lanes)
    jobs = [
        Job(
            keys,
            allowed(
                bench.lanes.take(np.tile(np.arange(count), len(numbers))),
                np.repeat([points[n].widths for n in numbers], count, axis=0),
            ),
            np.concatenate([points[n].each(bench) for n in numbers]),
            np.concatenate([points[n].own for n in numbers]),
            np.concatenate([searches[n].chosen for n in numbers]),
        )
        for keys, numbers in together.items()
    ]
    for numbers, columns in zip(together.values(), model.columns(jobs), strict=True):
        for place, number in enumerate(numbers):
            own = slice(place * count, (place + 1) * count)
            searches[number].see(points[number], Columns(*(each[own] for each in columns)), first)


class _Search:
    """One search under way."""

    def __init__(self, model: Model, bench: Bench, point: Point, free: np.ndarray, wander: bool) -> None:
        self.model, self.bench, self.point, self.free = model, bench, point, free
        self.wander = wander and bench.wanders
        self.chosen = chosen_columns(free, model.level, len(bench.lanes))
        self.dof = bench.dof()
        self.damping, self.cost, self.over, self.taken = 1e-3, np.inf, False, 0
        self.gain = np.inf
        self.lower = np.concatenate([model.lower[free], np.full(bench.runs, model.lower[-1])])
        self.upper = np.concatenate([model.upper[free], np.full(bench.runs, model.upper[-1])])

    def see(self, point: Point, columns: Columns, first: bool) -> None:
        """Takes the point if its cost is lower."""
        cost = whole_cost(columns)
        loss = Robust.around(cost, self.dof) if first else self.loss
        total = loss.total(cost) + self._prior(point).cost
        if not first and not total < self.cost:
            self.damping *= 10
            self.over = self.damping > STUCK
            return
        self.gain = gain = self.cost - total
        self.point, self.lane_cost, self.data = point, cost, data_cost(columns)
        self.gradient, self.curvature = normal(columns)
        moved = self._let_wander()
        cost = self.lane_cost
        self.loss = Robust.around(cost, self.dof)
        self.cost = self.loss.total(cost) + self._prior(point).cost
        if not first:
            self.damping = max(0.1 * self.damping, 1e-8)
            self.taken += 1
            self.over = gain < ENOUGH * total and not moved

    def _let_wander(self) -> bool:
        """Sets the widths to the likeliest ones at this point, and says whether they changed."""
        own, widths = self.point.own, self.point.widths
        found = likeliest(
            own,
            self.gradient[:, COLUMNS:],
            self.curvature[:, COLUMNS:, COLUMNS:],
            widths,
            self.data / self.dof,
        )
        self.price = found.price
        if not self.wander or np.array_equal(found.widths, widths):
            return False
        change = found.widths**-2.0 - widths**-2.0
        wandered = own[:, START:]
        places = COLUMNS + np.arange(START, OWN)
        self.gradient[:, places] += change * wandered
        self.curvature[:, places, places] += change
        dearer = (change * wandered**2).sum(1)
        self.lane_cost, self.data = self.lane_cost + dearer, self.data + dearer
        self.point = dataclasses.replace(self.point, widths=found.widths)
        return True

    def _prior(self, point: Point) -> Prior:
        return prior_of(self.model, self.bench, point, self.free)

    def step(self) -> Point:
        """Where the next damped step leads; what lanes have of their own is eliminated lane by lane."""
        n, runs = len(self.free), self.bench.runs
        own = self.curvature[:, COLUMNS:, COLUMNS:]
        own = own * (1 + self.damping * np.eye(OWN))
        used = 1 + n
        coupling = self.curvature[:, COLUMNS:, :used]
        solved = np.linalg.solve(own, np.concatenate([self.gradient[:, COLUMNS:, None], coupling], axis=2))
        gradient = self.gradient[:, :used] - np.einsum("lsc,ls->lc", coupling, solved[:, :, 0])
        curvature = self.curvature[:, :used, :used] - np.einsum("lsc,lsd->lcd", coupling, solved[:, :, 1:])
        weights = self.loss.weights(self.lane_cost)
        g, h = summed(gradient * weights[:, None], curvature * weights[:, None, None], self.bench)
        _, prior_gradient, prior = self._prior(self.point)
        at = np.concatenate([self.point.coordinates[self.free], self.point.levels])
        step, _ = bounded_step(
            at,
            g + prior_gradient,
            h + prior,
            self.damping,
            np.zeros(n + runs, bool),
            self.lower,
            self.upper,
        )
        reached = np.clip(at + step, self.lower, self.upper)
        step = reached - at
        coordinates = self.point.coordinates.copy()
        coordinates[self.free] = reached[:n]
        mine = np.concatenate(
            [step[n:][self.bench.run][:, None], np.tile(step[:n], (len(self.bench.run), 1))], axis=1
        )
        own = self.point.own - solved[:, :, 0] - np.einsum("lsc,lc->ls", solved[:, :, 1:], mine)
        return Point(self.point.keys, coordinates, reached[n:], own, self.point.widths)

    def result(self) -> Refit:
        return Refit(
            self.point,
            self.free,
            self.data,
            misfit_of(self.data, self.dof) * float(np.exp(self.price / self.dof.sum())),
            self.loss.weights(self.lane_cost),
            self.taken,
        )


class Prior(NamedTuple):
    """Twice the negative log prior, half its gradient, half its curvature."""

    cost: float
    gradient: np.ndarray
    curvature: np.ndarray


def prior_of(model: Model, bench: Bench, point: Point, free: np.ndarray) -> Prior:
    """The prior of the free unknowns and of every run's level. The mean level of the runs that have lanes is
    held at zero: the constants are those of the typical run."""
    n, runs = len(free), bench.runs
    cost, gradient, diagonal = model.prior(point.coordinates, free)
    curvature = np.zeros((n + runs, n + runs))
    curvature[:n, :n] = np.diag(diagonal)
    present = np.isin(np.arange(runs), bench.run) / len(np.unique(bench.run))
    curvature[n:, n:] = np.eye(runs) / LEVEL_TOLERANCE**2 + np.outer(present, present) / GAUGE**2
    pull = curvature[n:, n:] @ point.levels
    return Prior(cost + float(point.levels @ pull), np.concatenate([gradient, pull]), curvature)


def summed(gradient: np.ndarray, curvature: np.ndarray, bench: Bench) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (or several side by side) and curvature of the free unknowns and of every run's level, from
    those of lanes whose first column is the level."""
    n, runs = gradient.shape[1] - 1, bench.runs
    g, h = np.zeros((n + runs, *gradient.shape[2:])), np.zeros((n + runs, n + runs))
    g[:n], h[:n, :n] = gradient[:, 1:].sum(0), curvature[:, 1:, 1:].sum(0)
    np.add.at(g[n:], bench.run, gradient[:, 0])
    np.add.at(h, (n + bench.run, n + bench.run), curvature[:, 0, 0])
    across = np.zeros((runs, n))
    np.add.at(across, bench.run, curvature[:, 0, 1:])
    h[n:, :n], h[:n, n:] = across, across.T
    return g, h
