"""What hypotheses are judged on, and where one stands."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from fitting.diagnosis.lanes.model import Model
from fitting.lanes import Lanes


@dataclasses.dataclass(frozen=True)
class Bench:
    """The lanes that hypotheses are judged on, which run each belongs to (0 .. runs - 1), and how many runs
    the data set has, of which some may have no lane here.

    share: what noise alone leaves of the square of every residual of displacement and friction (lanes,
    samples, 2): 1, less where a sample is weighed down, 0 where it does not count; phase: a number for every
    lane, the same for lanes that begin at the same phase of the excitation in cycles of the same run, -1
    where no other does; wanders: whether friction may differ from lane to lane; scatters: whether residuals
    are weighed by what does not repeat itself from cycle to cycle, rather than by the noise of the sensors;
    whitener: matrices (lanes, rows, rows) that take residuals of displacement, then friction, to such as do
    not vary in step, None where they do not do so as they are.
    """

    lanes: Lanes
    run: np.ndarray
    runs: int
    share: np.ndarray
    phase: np.ndarray
    wanders: bool
    scatters: bool = False
    whitener: np.ndarray | None = None

    def dof(self) -> np.ndarray:
        """What noise alone costs every lane: its residuals that count, less the three of its start."""
        return np.maximum(self.share.sum(axis=(1, 2)) - 3, 1.0)

    def samples(self, time: float) -> float:
        """How many samples such a time [s] lasts, where they lie farthest apart."""
        return time / float(np.max(np.asarray(self.lanes.interval)))

    def take(self, index: np.ndarray) -> Bench:
        """The bench with some of the lanes; runs keep their numbers."""
        return dataclasses.replace(
            self,
            lanes=self.lanes.take(index),
            run=self.run[index],
            share=self.share[index],
            phase=self.phase[index],
            whitener=None if self.whitener is None else self.whitener[index],
        )

    def spread(self, lanes: int) -> np.ndarray:
        """The indices of so many lanes, or of all where there are fewer, spread evenly."""
        return np.unique(np.linspace(0, len(self.lanes) - 1, lanes).round().astype(int))

    def paced(self, substeps: int) -> Bench:
        """The bench with so many integration steps a sample."""
        return dataclasses.replace(self, lanes=dataclasses.replace(self.lanes, substeps=substeps))

    def coarser(self) -> Bench:
        """The bench with half as many integration steps a sample."""
        return self.paced(max(1, math.ceil(self.lanes.substeps / 2)))


@dataclasses.dataclass(frozen=True)
class Point:
    """A hypothesis at work: the effects attached, coordinates of all unknowns, those that every run has of
    its own (runs, `Model.by_run`: level of friction first), what every lane has of its own (lanes, 5: start,
    level and slope of friction), and the standard deviations of those levels and slopes.

    What runs have of their own stands among the coordinates as it is in the first of them. turned: links of
    the measuring chain in an order of their own, the last nearest to the contact, rather than in that of
    `keys`.
    """

    keys: tuple[str, ...]
    coordinates: np.ndarray
    by_run: np.ndarray
    own: np.ndarray
    widths: np.ndarray
    turned: tuple[str, ...] = ()

    @property
    def attached(self) -> tuple[str, ...]:
        """The effects in the order in which they are attached."""
        return self.arranged(self.keys)

    def acting(self, keys: Collection[str]) -> tuple[str, ...]:
        """Those of the attached effects that are among some, in the order in which they are attached."""
        return tuple(key for key in self.attached if key in keys)

    def arranged(self, keys: Sequence[str]) -> tuple[str, ...]:
        """Effects in the order in which they are attached here; given in that of the shelf."""
        turned = iter([key for key in self.turned if key in keys])
        return tuple(next(turned) if key in self.turned else key for key in keys)

    def each(self, model: Model, bench: Bench) -> np.ndarray:
        """Coordinates of every lane, with what its run has of its own."""
        each = np.tile(self.coordinates, (len(bench.lanes), 1))
        each[:, model.by_run] = self.by_run[bench.run]
        return each

    def take(self, index: np.ndarray) -> Point:
        """The point with what the lanes at these indices have of their own."""
        return dataclasses.replace(self, own=self.own[index])

    def among(self, own: np.ndarray, index: np.ndarray) -> Point:
        """The point for more lanes: its own stand at these indices, the others have what `own` says."""
        own = own.copy()
        own[index] = self.own
        return dataclasses.replace(self, own=own)

    def at_constants(self, model: Model, constants: np.ndarray) -> Point:
        """The point with these constants (coordinates)."""
        coordinates = self.coordinates.copy()
        coordinates[model.index(*model.constants)] = constants
        return dataclasses.replace(self, coordinates=coordinates)

    def without(self, model: Model, keys: Iterable[str]) -> Point:
        """The point with some effects at null and in their typical shape, still attached."""
        own = model.index(*(name for key in keys for name in model.shelf.names(key)))
        coordinates, by_run = self.coordinates.copy(), self.by_run.copy()
        coordinates[own] = model.origin({})[own]
        by_run[:, np.isin(model.by_run, own)] = 0.0
        return dataclasses.replace(self, coordinates=coordinates, by_run=by_run)
