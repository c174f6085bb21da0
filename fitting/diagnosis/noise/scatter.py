"""By how much the records scatter from cycle to cycle, channel by channel and phase by phase of the motion.

Friction that scatters may be nearly all that the force channel shows in slip, and hardly be felt in the
displacement: effects are told apart where little scatters, by residuals weighed with what does not repeat
itself (generalised least squares; Seber, Wild, Nonlinear Regression, 1989, section 2.1.4).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.ndimage import maximum_filter1d

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.columns import Columns
from fitting.diagnosis.lanes.cost import misfit_of
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.phases import phases_of
from fitting.diagnosis.lanes.wander import OWN
from fitting.diagnosis.noise.linked import whitener
from fitting.diagnosis.noise.repeatability import FEWEST, differences, successive

AROUND = 7
"""So many samples."""
LINKED = 1.3
"""Where the displacement, freed of what the friction force says, scatters by more than so many times as much
as before, it is not friction that moves it."""

NOTABLY = 1.3
"""Scatter is notably more than another if it is more than so many times that in one of the channels."""

Variances = dict[str, tuple[float, float]]
"""Mean squares of displacement and friction by phase of the motion, in units of the noise, 1 at least."""
Phases = dict[str, np.ndarray]
"""Which samples (lanes, samples) belong to each phase of the motion."""


@dataclasses.dataclass(frozen=True)
class Scatter:
    """The mean square of what does not repeat itself, in units of the noise, 1 at least: of displacement and
    friction, by phase of the motion; and what is left of it where the displacement is freed of what friction
    that scatters does to it, None where it does nothing to it. `period`: the natural one [s]."""

    variances: Variances
    left: Variances | None
    period: float

    def most(self) -> tuple[float, float]:
        """How many times the noise displacement and friction scatter in the phase where each does most."""
        displacement, friction = zip(*self.variances.values(), strict=True)
        return math.sqrt(max(displacement)), math.sqrt(max(friction))

    def exceeds(self, other: Scatter) -> bool:
        """Whether it is notably more than another."""
        return any(mine > NOTABLY * its for mine, its in zip(self.most(), other.most(), strict=True))

    @classmethod
    def of(cls, model: Model, bench: Bench, point: Point, period: float) -> Scatter:
        """That of a bench whose motion a hypothesis describes, good or bad: what it lacks repeats itself. A
        phase that is too rare to tell scatters as its channel does."""
        (columns,) = model.columns([job(model, bench, point)])
        phases = _phases(model, bench, columns, period)
        raw = cls(_unrepeated(bench, columns, phases), None, period)
        matrices = raw._freeing(model, bench, point, raw._deviation(bench, phases, raw.variances))
        if matrices is None:
            return raw
        left = _unrepeated(bench, columns.whitened(matrices), phases)
        whole, before = (max(pair[0] for pair in each.values()) for each in (left, raw.variances))
        return dataclasses.replace(raw, left=left) if whole < LINKED * before else raw

    def evened(self, model: Model, bench: Bench, point: Point) -> Bench:
        """A bench, whose motion the point describes, with its residuals in units of noise and scatter."""
        (columns,) = model.columns([job(model, bench, point)])
        phases = _phases(model, bench, columns, self.period)
        deviation = self._deviation(bench, phases, self.variances)
        displacement, friction = np.moveaxis(bench.lanes.weights() / deviation, 2, 0)
        lanes = dataclasses.replace(bench.lanes, displacement_weight=displacement, friction_weight=friction)
        matrices = None if self.left is None else self._freeing(model, bench, point, deviation)
        if self.left is not None and matrices is not None:
            still = self._deviation(bench, phases, self.left)
            matrices = _in_rows(1 / still)[:, :, None] * matrices * _in_rows(deviation)[:, None, :]
        return dataclasses.replace(bench, lanes=lanes, scatters=True, whitener=matrices)

    def _freeing(self, model: Model, bench: Bench, point: Point, deviation: np.ndarray) -> np.ndarray | None:
        """What frees residuals of what friction that scatters by `deviation` does to the displacement."""
        weights, root = bench.lanes.weights()[:, :, 1], np.sqrt(bench.share[:, :, 1])
        if not (weights > 0).any():
            return None
        noise = np.where(weights > 0, root / np.where(weights > 0, weights, 1.0), 0.0)
        noise = np.where(weights > 0, noise, np.median(noise[weights > 0]))
        return whitener(model, bench, point, noise * np.sqrt(deviation[:, :, 1] ** 2 - 1), self.period)

    @staticmethod
    def _deviation(bench: Bench, phases: Phases, variances: Variances) -> np.ndarray:
        """Standard deviations (lanes, samples, 2) by phase of the motion; for some samples around, what
        scatters most counts, since phases do not begin on the sample."""
        variance = np.ones(bench.share.shape)
        for name, mask in phases.items():
            variance[mask] = variances[name]
        return np.sqrt(maximum_filter1d(variance, AROUND, axis=1, mode="nearest"))


def _unrepeated(bench: Bench, columns: Columns, phases: Phases) -> Variances:
    first, second = successive(bench.phase)
    squares, noise = differences(bench, columns.residual[:, :-OWN], first, second)

    def variance(channel: int, mask: np.ndarray, otherwise: float) -> float:
        own = mask[first] & mask[second]
        expected = np.where(own, noise[:, channel], 0.0).sum(1)
        enough = expected > 1
        if enough.sum() < FEWEST:
            return otherwise
        cost = np.where(own, squares[:, channel], 0.0).sum(1)
        return max(misfit_of(cost[enough], expected[enough]), 1.0)

    every = np.ones(bench.share.shape[:2], bool)
    whole = [variance(channel, every, 1.0) for channel in (0, 1)]
    return {name: (variance(0, mask, whole[0]), variance(1, mask, whole[1])) for name, mask in phases.items()}


def _in_rows(values: np.ndarray) -> np.ndarray:
    """Values (lanes, samples, 2) in the order of residuals (lanes, rows)."""
    return values.transpose(0, 2, 1).reshape(len(values), -1)


def _phases(model: Model, bench: Bench, columns: Columns, period: float) -> Phases:
    _, slide_rate = model.sliding(bench.lanes, columns.states[:, :, 0], columns.states[:, :, 1])
    return phases_of(slide_rate, bench.share[:, :, 0] > 0, bench.samples(period))
