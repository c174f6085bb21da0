"""Where unknowns stand in the normal equations: those that all runs share once, those that every run has of
its own once for every run."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import LEVEL_TOLERANCE, Model

GAUGE = 1e-4
"""How closely the mean level of all runs is held at zero."""
LEVELLED = ("A", "C", "D")
"""The constants that a level of friction multiplies."""


class Prior(NamedTuple):
    """Twice the negative log prior, half its gradient, half its curvature."""

    cost: float
    gradient: np.ndarray
    curvature: np.ndarray


@dataclasses.dataclass(frozen=True)
class Layout:
    """The normal equations of a refit over some free unknowns and the level of friction.

    The columns of a lane are the level and the free unknowns. `shared` are the numbers of those that all runs
    share, `slots` the places in `Point.by_run` of those that every run has of its own, the level first;
    `index` (runs, columns) says where each column of a run's lanes stands in the equations: first what is
    shared, then slot by slot one entry for every run. `runs` are those that have lanes.
    """

    shared: np.ndarray
    slots: np.ndarray
    index: np.ndarray
    runs: np.ndarray

    @classmethod
    def of(cls, model: Model, bench: Bench, free: np.ndarray) -> Layout:
        columns = np.concatenate([[model.level], free]).astype(int)
        apart = np.isin(columns, model.by_run)
        shared, slots = columns[~apart], model.slots(columns[apart])
        index = np.empty((bench.runs, len(columns)), int)
        index[:, ~apart] = np.arange(len(shared))
        index[:, apart] = len(shared) + np.arange(len(slots) * bench.runs).reshape(len(slots), bench.runs).T
        return cls(shared, slots, index, np.unique(bench.run))

    @property
    def of_free(self) -> np.ndarray:
        """Where every free unknown stands; of what runs have of their own, the first run's that has lanes."""
        return self.index[self.runs[0], 1:]

    def fits_friction(self, model: Model) -> bool:
        """Whether what a level of friction multiplies is free, so that the mean level is no news."""
        return bool(np.isin(model.index(*LEVELLED), self.shared).all())

    def values(self, point: Point) -> np.ndarray:
        """The unknowns of a point in the order of the equations."""
        return np.concatenate([point.coordinates[self.shared], point.by_run[:, self.slots].T.ravel()])

    def bounds(self, model: Model) -> tuple[np.ndarray, np.ndarray]:
        """The lowest and highest values of the unknowns in the order of the equations."""
        numbers = np.concatenate([self.shared, np.repeat(model.by_run[self.slots], len(self.index))])
        return model.lower[numbers], model.upper[numbers]

    def moved(self, model: Model, point: Point, values: np.ndarray) -> Point:
        """The point with its unknowns at these values. What every run has of its own, but for the level,
        stands among the coordinates as it is in the first run that has lanes."""
        coordinates, by_run = point.coordinates.copy(), point.by_run.copy()
        coordinates[self.shared] = values[: len(self.shared)]
        by_run[:, self.slots] = values[len(self.shared) :].reshape(len(self.slots), -1).T
        own = self.slots[1:]
        coordinates[model.by_run[own]] = by_run[self.runs[0], own]
        return dataclasses.replace(point, coordinates=coordinates, by_run=by_run)

    def summed(
        self, run: np.ndarray, gradient: np.ndarray, curvature: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Gradient (or several side by side) and curvature of the unknowns, from those (lanes, columns, ..)
        and (lanes, columns, columns) of lanes that belong to these runs."""
        size = int(self.index.max()) + 1
        g, h = np.zeros((size, *gradient.shape[2:])), np.zeros((size, size))
        for number in np.unique(run):
            place, mine = self.index[number], run == number
            g[place] += gradient[mine].sum(0)
            h[np.ix_(place, place)] += curvature[mine].sum(0)
        return g, h

    def prior(self, model: Model, point: Point) -> Prior:
        """The prior of the unknowns. Where friction is fitted the mean level of the runs that have lanes is
        held at zero: constants are those of the typical run. Other runs may all lie on one side of that."""
        values, n, runs = self.values(point), len(self.shared), len(self.index)
        numbers = np.concatenate([self.shared, np.repeat(model.by_run[self.slots[1:]], runs)])
        plain = np.concatenate([np.arange(n), np.arange(n + runs, len(values))])
        cost, pull, diagonal = model.prior(values[plain], numbers)
        gradient, curvature = np.zeros(len(values)), np.zeros((len(values), len(values)))
        gradient[plain], curvature[plain, plain] = pull, diagonal
        levels = slice(n, n + runs)
        present = np.isin(np.arange(runs), self.runs) / len(self.runs)
        curvature[levels, levels] = np.eye(runs) / LEVEL_TOLERANCE**2
        if self.fits_friction(model):
            curvature[levels, levels] += np.outer(present, present) / GAUGE**2
        gradient[levels] = curvature[levels, levels] @ values[levels]
        return Prior(cost + float(values[levels] @ gradient[levels]), gradient, curvature)


def owners(model: Model, bench: Bench, key: str) -> list[tuple[int, int | None]]:
    """The strengths of an effect that are screened: the number of each, and the run that has it of its own,
    None where all runs share it."""
    runs = np.unique(bench.run).tolist()
    return [
        (number, run)
        for number in model.index(*model.shelf.strengths[key]).tolist()
        for run in (runs if number in model.by_run else [None])
    ]


def strengths_of(model: Model, bench: Bench, point: Point, key: str) -> np.ndarray:
    """The strengths of an effect as they stand, in the order of their owners."""
    return np.array(
        [
            point.coordinates[number] if run is None else point.by_run[run, model.by_run == number].item()
            for number, run in owners(model, bench, key)
        ]
    )


def with_strengths(model: Model, bench: Bench, point: Point, key: str, strengths: np.ndarray) -> Point:
    """The point with these strengths of an effect, in the order of their owners."""
    coordinates, by_run = point.coordinates.copy(), point.by_run.copy()
    owned = list(zip(owners(model, bench, key), strengths.tolist(), strict=True))
    for (number, run), strength in reversed(owned):
        coordinates[number] = strength
        if run is not None:
            by_run[run, model.by_run == number] = strength
    return dataclasses.replace(point, coordinates=coordinates, by_run=by_run)
