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
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model, Prediction
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly
from fitting.diagnosis.where.beat import durations, frequencies, gained_by_run, refined
from fitting.diagnosis.where.sides import motion_side
from fitting.problem import Problem

AROUND = 101
"""A line stands out from the median of so many frequencies around it."""
CHANCE = 1e-4
"""The probability with which any of the frequencies would stand out so by chance. In 20 sealed cases without
any effect the least was 0.02; in eight of 13 in which a gear meshed it was below 1e-11."""
MOST = 12.0
"""One run says so much (a logarithm of its chance) at most, and no line is seen in a single one."""
SEEN = 4.0
"""In half of the runs it is to be more than this, and in half of those of whose drive it is no harmonic:"""
APART, HIGHEST = 0.75, 40
"""what has so many cycles in a run more or less is none, and none shows of a higher order than this."""
NEAR = 2.5
"""So many cycles in a run around there, it is where a sine takes most of chi-square from all runs."""


@dataclasses.dataclass(frozen=True)
class OwnBeat(AbstractAnomaly):
    """The frequency [Hz] of a force on the mass, and in how many runs it is seen, of how many;
    `friction_known`: friction is none of it, for it was measured."""

    frequency: float
    runs: int
    of: int
    friction_known: bool

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
            "gears, motors, pumps or the frame do."
        )

    @property
    def look(self) -> str:
        return (
            "Record with the drive standing still and the vibration of the frame beside the motion, and "
            f"switch off what rotates one by one: what keeps {self.frequency:.4g} Hz alive is found so."
        )

    @property
    def side(self) -> str | None:
        return "mechanics" if self.friction_known else None


def own_beat(problem: Problem, model: Model, bench: Bench, point: Point, seen: Prediction) -> OwnBeat | None:
    """What there is of one under the nominal model, which is at the point; None where none is surely there.
    `seen`: what the bench shows there."""
    tried = frequencies(problem, bench)
    side = motion_side(problem, model, bench, point, seen)
    if tried is None or side is None:
        return None
    drives, lasts = [frequency_of(signal.run) for signal in problem.chosen], durations(problem)
    gain = gained_by_run(problem, bench, side, drives, tried)
    telling = [number for number, mine in enumerate(gain) if mine.any()]
    if not telling:
        return None
    says = np.stack([_says(gain[number]) for number in telling])
    chance = len(tried) * gammaincc(len(says), says.sum(axis=0))
    seen_in = says > SEEN
    own = np.stack([_is_no_harmonic(tried, drives[number], lasts[number]) for number in telling])
    sure = (chance < CHANCE) & (2 * seen_in.sum(axis=0) >= len(says))
    sure &= 2 * (seen_in & own).sum(axis=0) >= np.maximum(own.sum(axis=0), 1)
    if not sure.any():
        return None
    best = int(np.argmax(np.where(sure, gain.sum(axis=0), 0.0)))
    free = [None] * len(drives)
    near = np.abs(tried - tried[best]) * min(lasts) < NEAR
    whole = gained_by_run(problem, bench, side, free, tried).sum(axis=0)
    at = int(np.argmax(np.where(near, whole, 0.0)))
    frequency = refined(problem, bench, side, free, tried, at)
    runs = int(np.count_nonzero(seen_in[:, best]))
    return OwnBeat(frequency, runs, len(says), problem.friction_recorded)


def _says(gain: np.ndarray) -> np.ndarray:
    """The logarithm of one over the chance of what a sine of each frequency gains in a run, by what is usual
    around it; 0 where it gains nothing."""
    counts = gain > 0
    usual = median_filter(gain[counts], AROUND, mode="reflect") / math.log(2)
    says = np.zeros(len(gain))
    says[counts] = np.minimum(gain[counts] / usual, MOST)
    return says


def _is_no_harmonic(tried: np.ndarray, drive: float | None, lasts: float) -> np.ndarray:
    """Which frequencies [Hz] are surely no harmonics of that of a run's drive (None for none), which lasts so
    long [s]."""
    if drive is None:
        return np.ones(len(tried), bool)
    order = np.round(tried / drive)
    return (order > HIGHEST) | (np.abs(tried - order * drive) * lasts > APART)
