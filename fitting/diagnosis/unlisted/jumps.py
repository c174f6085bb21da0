"""Friction that jumps while the mass slides fast: debris that enters the contact or leaves it, a load that
drops on or off, a loose contact of the sensor.

Friction that scatters, or that follows speed, place or time, does so gradually; from one sample to the next
it keeps its level but for the noise. What a jump is told by is that it is over within a sample or two, that
it is far above what friction changes by in as short a time elsewhere in the run, and that neither the speed
nor the model does anything there. Small ones show where friction that scatters as far hides how high it lies.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.signal import find_peaks

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Prediction
from fitting.diagnosis.lanes.steadiness import robust_deviation
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly

SPAN, SHORT = 4, 2
"""Means over so many samples are compared before and behind each, and over so few,"""
FAST = 0.5
"""where the mass is faster than this share of the root mean square of its speed in the run."""
FEWEST_PLACES = 100
"""So many are needed to say anything of a run."""
FAR = 6.0
"""A jump is more than so many robust standard deviations of these differences in the run,"""
ON_LEVEL = 0.5
"""comes where friction is more than this share of its level, for else it is about to turn,"""
AT_ONCE = 0.8
"""has this share of its height over the short span already,"""
LASTS = 0.5
"""is no single sample that is off, but has this share of it between medians as well,"""
UNSEEN = 0.3
"""and is none of the model, which makes less than this share of it: where it turns, or sticks, when the mass
does not, it differs by as much as suddenly."""


@dataclasses.dataclass(frozen=True)
class Jumps(AbstractAnomaly):
    """How often friction jumps, in how many runs, of how many, and by what share of itself (median)."""

    count: int
    runs: int
    of: int
    height: float

    @property
    def clause(self) -> str:
        return (
            f"friction jumps while the mass slides, by {100 * self.height:.2g} % in {self.runs} of {self.of} "
            "runs, as debris in the contact or a load that drops makes it"
        )

    @property
    def note(self) -> str:
        return (
            f"In {self.runs} of {self.of} runs friction jumps within a sample or two while the mass slides "
            f"fast, {self.count} times in all, by {100 * self.height:.2g} % of itself: look for particles or "
            "debris in the contact, for a load that drops on or off, and for a loose contact of the sensor."
        )

    @property
    def look(self) -> str:
        return (
            "Record the normal load beside the friction force, and the same run before and after the "
            "surfaces are cleaned and the plugs of the force sensor tightened: a load that drops jumps as "
            "friction does, debris goes with the cleaning, a loose contact with the tightening."
        )

    @property
    def side(self) -> str:
        return "friction"


def jumps(bench: Bench, seen: Prediction) -> Jumps | None:
    """What there is of jumps in more than half of the runs, None where there is not as much, or no friction
    force. `seen`: what the bench shows under the nominal model.

    In eight sealed cases with particles in the contact, two of them with friction that scatters as far, it
    jumped in four to six of six runs but for one; in 93 without any effect, and in 74 with something else off
    the shelf that is not in the converter, in three at most.
    """
    counts = np.asarray(bench.lanes.friction_weight) > 0
    sense, steady = np.sign(seen.friction), np.abs(seen.friction)
    recorded = np.asarray(bench.lanes.friction) * sense
    found: list[np.ndarray] = []
    for run in np.unique(bench.run[counts.any(axis=1)]):
        mine = bench.run == run
        level = np.median(steady[mine][counts[mine]])
        heights = _heights(recorded[mine] / level, steady[mine] / level, seen.velocity[mine], counts[mine])
        if heights is not None:
            found.append(heights)
    where = [heights for heights in found if len(heights)]
    if 2 * len(where) <= len(found):
        return None
    every = np.concatenate(where)
    return Jumps(len(every), len(where), len(found), float(np.median(every)))


def _heights(
    recorded: np.ndarray, expected: np.ndarray, velocity: np.ndarray, counts: np.ndarray
) -> np.ndarray | None:
    """The heights of the jumps of a run, from its friction as recorded and as modelled (lanes, samples), both
    against the sense of sliding and as shares of its level; None where there is too little fast sliding."""
    speed = np.abs(velocity)
    within = counts & (speed > FAST * np.sqrt(np.mean(velocity**2)))
    looked_at = sliding_window_view(within, 2 * SPAN, axis=1).all(axis=2)
    if np.count_nonzero(looked_at) < FEWEST_PLACES:
        return None
    rise = _rises(recorded - expected)
    usual, scale = np.median(rise[looked_at]), robust_deviation(rise[looked_at])
    off = np.where(looked_at, np.abs(rise - usual), 0.0)
    heights = []
    for lane in range(len(off)):
        for place in find_peaks(off[lane], height=FAR * scale, distance=2 * SPAN)[0]:
            around = slice(place, place + 2 * SPAN)
            if _is_a_jump(recorded[lane, around], expected[lane, around]):
                heights.append(abs(rise[lane, place]))
    return np.array(heights)


def _rises(values: np.ndarray) -> np.ndarray:
    """By how much the mean of `SPAN` samples exceeds that of as many before (lanes, places)."""
    means = sliding_window_view(values, SPAN, axis=1).mean(axis=2)
    return means[:, SPAN:] - means[:, :-SPAN]


def _is_a_jump(recorded: np.ndarray, expected: np.ndarray) -> bool:
    """Whether friction, as recorded and as modelled in `SPAN` samples before a place and as many behind it,
    goes from one level to another there at once and by itself."""
    beyond = recorded - expected
    height, modelled = _rises(beyond[None]).item(), _rises(expected[None]).item()
    sense, size = np.sign(height), abs(height)
    short = [
        beyond[middle : middle + SHORT].mean() - beyond[middle - SHORT : middle].mean()
        for middle in range(SPAN - 1, SPAN + 2)
    ]
    at_once = max(sense * step for step in short)
    lasts = sense * (np.median(beyond[SPAN:]) - np.median(beyond[:SPAN]))
    unseen = abs(modelled) < UNSEEN * abs(height + modelled)
    return bool(recorded.min() > ON_LEVEL and at_once > AT_ONCE * size and lasts > LASTS * size and unseen)
