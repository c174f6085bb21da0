"""Refits: several hypotheses fitted side by side to the same lanes, every lane's start and every run's level
of friction free, and the friction of every lane as far as it wanders."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from fitting.diagnosis.bench import Bench, Point
from fitting.diagnosis.columns import Columns
from fitting.diagnosis.layout import LEVELLED, Layout, Prior
from fitting.diagnosis.model import Job, Model
from fitting.diagnosis.programs import COLUMNS
from fitting.diagnosis.steadiness import Levels
from fitting.diagnosis.wander import OWN, START, allowed, likeliest
from fitting.newton import Robust, bounded_step

ITERATIONS = 30
ENOUGH, ENOUGH_OF_SCATTER = 2e-4, 1e-3
"""A search is over when a step has gained, or promises to gain, less than this share of the cost. Where
residuals are weighed by what does not repeat itself, a lane is worth few independent pieces of evidence, and
five times as much tells nothing."""
DAMPED, LEAST_DAMPED, STUCK = 1e-3, 1e-4, 1e7
"""The damping that a search begins with, what it does not fall below, for steps hardly differ there, and one
that is refused would be tried over and over, and where a search is given up."""
EASED, GROWS = 0.1, 10.0
"""By what factor a step that is taken changes the damping, and one that is refused."""
PATIENCE = 8.0
LEAST_TURNS = 4
BROKEN = 1e30
"""What a lane costs whose motion is no number, as with parameters that no rig has."""


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
        _Search(model, bench, point, free, wander, enough) for point, free in zip(points, frees, strict=True)
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
    return [search.result() for search in searches]


def misfit_of(cost: np.ndarray, dof: np.ndarray) -> float:
    """Chi-square per degree of freedom; of lanes far above the typical one, what Huber leaves of them."""
    return Robust.around(cost, dof).total(cost) / float(dof.sum())


def whole_cost(columns: Columns) -> np.ndarray:
    """The cost of every lane with the prior of its start."""
    return _finite(np.einsum("lr,lr->l", columns.residual, columns.residual))


def data_cost(columns: Columns) -> np.ndarray:
    """The cost of every lane without the prior of its start."""
    with np.errstate(over="ignore"):
        squares = columns.residual**2
    return _finite(squares[:, :-OWN].sum(1) + squares[:, START - OWN :].sum(1))


def _finite(cost: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(cost), cost, BROKEN)


def normal(columns: Columns) -> tuple[np.ndarray, np.ndarray]:
    """J'r and J'J of every lane, what it has of its own last; no pull at all of a lane where they are no
    numbers."""
    jacobian = columns.jacobian
    with np.errstate(over="ignore", invalid="ignore"):
        gradient = np.einsum("lrc,lr->lc", jacobian, columns.residual)
        curvature = jacobian.transpose(0, 2, 1) @ jacobian
    broken = ~(np.isfinite(gradient).all(1) & np.isfinite(curvature).all((1, 2)))
    gradient[broken], curvature[broken] = 0.0, np.eye(gradient.shape[1])
    return gradient, curvature


def fall(gradient: np.ndarray, curvature: np.ndarray, change: np.ndarray) -> np.ndarray:
    """By how much the linearised cost of every lane falls for a change (lanes, each) of its unknowns, given
    J'r and J'J by them."""
    slope = np.einsum("lc,lc->l", change, gradient)
    return -2 * slope - np.einsum("lc,lcd,ld->l", change, curvature, change)


class Projection:
    """Takes out of values (lanes, rows, ..) what each lane can make of them by itself."""

    def __init__(self, columns: Columns) -> None:
        self._basis, self._root = np.linalg.qr(columns.jacobian[:, :, COLUMNS:])

    def __call__(self, values: np.ndarray) -> np.ndarray:
        return values - self._basis @ (self._basis.transpose(0, 2, 1) @ values)

    def answer(self, values: np.ndarray) -> np.ndarray:
        """By how much what each lane has of its own (lanes, own, ..) is to move where residuals change by
        these values, for the least cost."""
        root = self._root + 1e-30 * np.eye(OWN)
        return -np.linalg.solve(root, self._basis.transpose(0, 2, 1) @ values)


def chosen_columns(free: np.ndarray, level: int, lanes: int) -> np.ndarray:
    """What the program differentiates by: the level of friction first, then the free unknowns."""
    row = np.full(COLUMNS, -1)
    row[0] = level
    row[1 : 1 + len(free)] = free
    return np.tile(row, (lanes, 1))


def within_columns(model: Model, *unknowns: np.ndarray) -> np.ndarray:
    """Unknowns that are to be free, as many as the program has columns for beside the level of friction.

    Where there are more, what the rig has within its tolerance stays as it was found before, the mass first.
    """
    free = np.concatenate(unknowns)
    spare = [number for number in model.of_rig().tolist() if number in free]
    free = free[~np.isin(free, spare[: max(0, len(free) - (COLUMNS - 1))])]
    return free[: COLUMNS - 1]


def centred(model: Model, bench: Bench, point: Point) -> Point:
    """The same motion with levels of friction where they belong: the mean of a run's lanes is the run's, the
    mean of all runs in A, C and D, which levels multiply. A search that may damp every lane's steps would
    leave them for long where they do not.
    """
    levelled = in_runs(bench, point)
    by_run, coordinates = levelled.by_run.copy(), point.coordinates.copy()
    runs = np.unique(bench.run)
    common = by_run[runs, 0].mean()
    by_run[runs, 0] -= common
    levelled_by = model.index(*LEVELLED)
    for number in levelled_by:
        member = model.members[number]
        coordinates[number] = member.to_coordinate(member.to_value(coordinates[number]) * math.exp(common))
    inside = ((coordinates >= model.lower) & (coordinates <= model.upper))[levelled_by]
    if not inside.all() or np.abs(by_run[:, 0]).max() > model.upper[model.level]:
        return point
    return dataclasses.replace(levelled, coordinates=coordinates, by_run=by_run)


def in_runs(bench: Bench, point: Point) -> Point:
    """The same motion with what the levels of a run's lanes have in common in the run's own."""
    own, by_run = point.own.copy(), point.by_run.copy()
    for run in np.unique(bench.run):
        mean = own[bench.run == run, START].mean()
        own[bench.run == run, START] -= mean
        by_run[run, 0] += mean
    return dataclasses.replace(point, by_run=by_run, own=own)


def job(model: Model, bench: Bench, point: Point, chosen: np.ndarray | None = None) -> Job:
    """The linearisation of a bench at a point, by what each lane has of its own and the chosen unknowns."""
    if chosen is None:
        chosen = np.full((len(bench.lanes), COLUMNS), -1)
    deviation = allowed(bench.lanes, point.widths)
    return Job(
        point.attached, bench.lanes, deviation, point.each(model, bench), point.own, chosen, bench.whitener
    )


def _evaluate(
    model: Model, bench: Bench, searches: Sequence[_Search], points: Sequence[Point], *, first: bool
) -> None:
    """Lets every search see its point; searches with the same effects share their packs."""
    together: dict[tuple[str, ...], list[int]] = {}
    for number, point in enumerate(points):
        together.setdefault(point.attached, []).append(number)
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
        for keys, numbers in together.items()
    ]
    seen = {
        number: columns.part(slice(place * count, (place + 1) * count))
        for numbers, columns in zip(together.values(), model.columns(jobs), strict=True)
        for place, number in enumerate(numbers)
    }
    model.side_by_side(lambda number: searches[number].see(points[number], seen[number], first), seen)


class _Search:
    """One search under way."""

    def __init__(
        self,
        model: Model,
        bench: Bench,
        point: Point,
        free: np.ndarray,
        wander: bool,
        enough: float | None = None,
    ) -> None:
        self.model, self.bench, self.point, self.free = model, bench, point, free
        self.wander = wander and bench.wanders
        self.chosen = chosen_columns(free, model.level, len(bench.lanes))
        self.dof = bench.dof()
        self.damping, self.cost, self.gain = DAMPED, np.inf, np.inf
        self.over, self.taken = False, 0
        usual = ENOUGH_OF_SCATTER if bench.scatters else ENOUGH
        self.enough = usual if enough is None else enough
        self.layout = Layout.of(model, bench, free)
        self.centres = self.wander and self.layout.fits_friction(model)
        self.lower, self.upper = self.layout.bounds(model)

    def see(self, point: Point, columns: Columns, first: bool) -> None:
        """Takes the point if its cost is lower."""
        cost = whole_cost(columns)
        loss = Robust.around(cost, self.dof) if first else self.loss
        total = loss.total(cost) + self._prior(point).cost
        if not first and not total < self.cost:
            self.damping *= GROWS
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
            self.damping = max(EASED * self.damping, LEAST_DAMPED)
            self.taken += 1
            self.over = gain < self.enough * total and not moved

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
        self.price, self.levels = found.price, found.levels
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
        return self.layout.prior(self.model, point)

    def step(self) -> Point:
        """Where the next damped step leads; what lanes have of their own is eliminated lane by lane. The
        search is over where the step promises next to nothing."""
        g, h, solved = self._without_own(self.damping)
        _, prior_gradient, prior = self._prior(self.point)
        at = self.layout.values(self.point)
        step, _ = bounded_step(
            at,
            g + prior_gradient,
            h + prior,
            self.damping,
            np.zeros(len(at), bool),
            self.lower,
            self.upper,
        )
        reached = np.clip(at + step, self.lower, self.upper)
        step = reached - at
        mine = step[self.layout.index[self.bench.run]]
        answer = -solved[:, :, 0] - np.einsum("lsc,lc->ls", solved[:, :, 1:], mine)
        promised = self.loss.weights(self.lane_cost) @ self._fall(np.concatenate([mine, answer], axis=1))
        promised -= step @ (2 * prior_gradient + prior @ step)
        self.over = bool(promised < self.enough * self.cost)
        own = self.point.own + answer
        point = dataclasses.replace(self.layout.moved(self.model, self.point, reached), own=own)
        return centred(self.model, self.bench, point) if self.centres else point

    def _without_own(self, damping: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gradient and curvature of the unknowns, what lanes have of their own eliminated lane by lane, and
        how that answers to the gradient of a lane and to its unknowns (lanes, own, 1 + unknowns)."""
        own = self.curvature[:, COLUMNS:, COLUMNS:]
        own = own * (1 + damping * np.eye(OWN))
        used = 1 + len(self.free)
        coupling = self.curvature[:, COLUMNS:, :used]
        solved = np.linalg.solve(own, np.concatenate([self.gradient[:, COLUMNS:, None], coupling], axis=2))
        gradient = self.gradient[:, :used] - np.einsum("lsc,ls->lc", coupling, solved[:, :, 0])
        curvature = self.curvature[:, :used, :used] - np.einsum("lsc,lsd->lcd", coupling, solved[:, :, 1:])
        weights = self.loss.weights(self.lane_cost)
        g, h = self.layout.summed(
            self.bench.run, gradient * weights[:, None], curvature * weights[:, None, None]
        )
        return g, h, solved

    def _told(self) -> dict[int, float]:
        """How many times as much as its prior the records say of each free unknown; infinite without one."""
        _, h, _ = self._without_own(LEAST_DAMPED)
        prior = self._prior(self.point).curvature
        variance = np.diag(np.linalg.pinv(h + prior, hermitian=True))[self.layout.of_free]
        assumed = np.diag(prior)[self.layout.of_free]
        with np.errstate(divide="ignore"):
            told = np.maximum(1.0 / (assumed * np.maximum(variance, 1e-300)) - 1.0, 0.0)
        return dict(zip(self.free.tolist(), told.tolist(), strict=True))

    def _fall(self, change: np.ndarray) -> np.ndarray:
        """By how much the linearised cost of every lane falls for a change of its unknowns, its own last."""
        used = np.r_[: 1 + len(self.free), COLUMNS : COLUMNS + OWN]
        return fall(self.gradient[:, used], self.curvature[:, used[:, None], used], change)

    def result(self) -> Refit:
        return Refit(
            self.point,
            self.free,
            self.data,
            misfit_of(self.data, self.dof) * float(np.exp(self.price / self.dof.sum())),
            self.loss.weights(self.lane_cost),
            self.taken,
            self.levels,
            self._told(),
        )
