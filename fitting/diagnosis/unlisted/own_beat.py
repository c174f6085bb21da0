"""A beat that is surely there: a force on the mass that oscillates in the runs alike, whatever their drives
do.

It repeats itself with no cycle of the excitation, so that, with friction that scatters, it is taken for
scatter as well. In the equation of motion, closed with the friction force that was measured, scatter cancels,
and a line stands above the periodogram around it. How surely is told by Fisher's sum over runs of the
logarithms of their chances (Statistical Methods for Research Workers, 4th ed., 1932, section 21.1): where
nothing oscillates, what a sine gains is exponentially distributed (Lomb, Astrophysics and Space Science 39
(1976) 447).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import gammaincc

from fitting.cycle import frequency_of
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.ground import Ground
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly
from fitting.diagnosis.where.beat import frequencies, gained_by_run, refined
from fitting.diagnosis.where.sides import motion_side
from fitting.problem import Problem
from jaxstick.record import Run

AROUND = 101
"""A line stands out from the median of so many frequencies around it."""
CHANCE = 1e-4
"""The probability with which any of the frequencies would stand out so by chance. In 20 sealed cases without
any effect the least was 0.02; in eight of 13 in which a gear meshed it was below 1e-11."""
MOST = 12.0
"""One run says so much (a logarithm of its chance) at most, and no line is seen in a single one."""
APART = 0.75
"""A harmonic of its drive, of whatever order, says nothing, nor does what has so few cycles more or less."""
SEEN = 4.0
"""In half of the runs it is to be more than this."""


@dataclasses.dataclass(frozen=True)
class OwnBeat(AbstractAnomaly):
    """The frequency [Hz] of a force on the mass, and in how many runs it is seen, of how many."""

    frequency: float
    runs: int
    of: int

    @property
    def clause(self) -> str:
        return (
            f"a force on the mass oscillates at {self.frequency:.4g} Hz, whatever the frequency of the drive"
        )

    @property
    def note(self) -> str:
        return (
            f"In {self.runs} of {self.of} runs a force on the mass oscillates at {self.frequency:.4g} Hz, "
            "whatever the frequency of the drive: look for what rotates, or rings, at that frequency, as "
            "gears, motors, pumps or the frame do; record it with the drive standing still."
        )


def own_beat(problem: Problem, model: Model, base: Ground) -> OwnBeat | None:
    """What there is of one under the nominal model; None where none is surely there."""
    bench, point = base.bench, base.point
    tried = frequencies(problem, bench)
    seen = model.predict(point.attached, bench.lanes, point.each(model, bench), point.own)
    side = motion_side(problem, model, bench, point, seen)
    if tried is None or side is None:
        return None
    runs = [signal.run for signal in problem.chosen]
    drives = [frequency_of(run) for run in runs]
    gain = gained_by_run(problem, bench, side, drives, tried)
    told = [_says(mine, tried, run) for mine, run in zip(gain, runs, strict=True) if mine.any()]
    if not told:
        return None
    says = np.stack(told)
    chance = len(tried) * gammaincc(len(says), says.sum(axis=0))
    best = int(np.argmin(chance))
    many = int(np.count_nonzero(says[:, best] > SEEN))
    if chance[best] > CHANCE or 2 * many < len(says):
        return None
    return OwnBeat(refined(problem, bench, side, drives, tried, best), many, len(says))


def _says(gain: np.ndarray, tried: np.ndarray, run: Run) -> np.ndarray:
    """The logarithm of one over the chance of what a sine of each frequency gains in a run, by what is usual
    around it; 0 for harmonics of its drive."""
    counts = gain > 0
    usual = median_filter(gain[counts], AROUND, mode="reflect") / math.log(2)
    says = np.zeros(len(gain))
    says[counts] = np.minimum(gain[counts] / usual, MOST)
    drive = frequency_of(run)
    if drive is not None:
        apart = np.abs(tried - np.round(tried / drive) * drive) * float(np.ptp(run.time))
        says[apart < APART] = 0.0
    return says
