"""How steady friction is: evidence from the levels that friction has in lane after lane.

An effect that changes friction slowly, with time, place or load, can be taken for friction that wanders; the
misfit of either is much the same, for levels are few beside samples. What tells them apart is how the levels
go on from lane to lane: friction that wanders does so in every run in its own way, an effect makes it keep
still in all of them. Levels are a Gaussian process with an exponential covariance and a part that is new in
every lane (Rasmussen, Williams, Gaussian Processes for Machine Learning, 2006, sections 2.2 and 4.2.1), whose
scale, share and length are the likeliest ones; a random walk is the longest. What all lanes of a run have in
common says nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.stats import median_abs_deviation

SCALES = np.geomspace(1e-3, 0.3, 25)
"""Standard deviations that are tried; friction keeps no stiller than the least, whatever a model says."""
LENGTHS = (1.0, 3.0, 10.0, math.inf)
"""Correlation lengths in lanes that are tried."""
NEW = (0.0, 0.3, 1.0)
"""How much of a level is new in every lane, as a multiple of the scale."""
COMMON = 1.0
"""Standard deviation of what all lanes of a run share."""
FARTHEST = 0.5
"""A level that is further off, or no number, is an event that was lost."""
FAR, MEDIAN_DISTANCE = 2.0, 0.6745
"""No level counts as further from the typical one of its run than so many standard deviations; and the median
distance of normal values, in these."""


class Levels(NamedTuple):
    """The level of friction in every lane as its own samples tell it, the variance of that, and whether it is
    to be counted."""

    best: np.ndarray
    variance: np.ndarray
    counts: np.ndarray

    def where_none_lost(self, others: Iterable[Levels]) -> Levels:
        """The levels, counted where none of the others has lost an event: what is compared by them is
        compared in the same lanes."""
        kept = [np.abs(np.nan_to_num(other.best, nan=np.inf)) < FARTHEST for other in others]
        return self._replace(counts=self.counts & np.all(kept, axis=0))


def steadier(before: Levels, after: Levels, run: np.ndarray) -> float:
    """By how much likelier levels are once an effect has been let in than before (a logarithm; negative where
    they are less likely).

    `run` says which run a lane belongs to, in the order of time. Lanes count and levels are known as before;
    a lane that has lost an event before or after says nothing.
    """
    known = before.where_none_lost([before, after])
    then, now = (_likelihood(each, known, run) for each in _without_strays(before, after, known.counts, run))
    return now - then


def robust_deviation(values: np.ndarray) -> float:
    """The standard deviation of normal values that lie as far around their median."""
    return float(median_abs_deviation(values, scale=MEDIAN_DISTANCE))


def _without_strays(
    before: Levels, after: Levels, counts: np.ndarray, run: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Levels before and after (lanes) with those that stray no further off than levels mostly do: in a few
    lanes events were lost that shift a level far, and these would decide."""
    then, now = before.best.copy(), after.best.copy()
    for number in np.unique(run[counts]):
        lanes = (run == number) & counts
        spread = (robust_deviation(values[lanes]) for values in (then, now))
        most = FAR * max(SCALES[0], *spread)
        for values in (then, now):
            middle = float(np.median(values[lanes]))
            values[lanes] = np.clip(values[lanes], middle - most, middle + most)
    return then, now


def _likelihood(levels: np.ndarray, known: Levels, run: np.ndarray) -> float:
    """The logarithmic likelihood of levels under the process that makes it largest."""
    counts = known.counts & np.isfinite(known.variance)
    total = np.zeros((len(LENGTHS) * len(NEW), len(SCALES)))
    for number in np.unique(run):
        lanes = np.flatnonzero(run == number)
        place = np.flatnonzero(counts[lanes])
        lanes = lanes[place]
        if len(lanes) < 2:
            continue
        kernels = np.array([_kernel(place, length, new) for length in LENGTHS for new in NEW])
        spread = np.diag(known.variance[lanes]) + COMMON**2
        covariance = kernels[:, None] * SCALES[:, None, None] ** 2 + spread
        root = np.linalg.cholesky(covariance)
        white = np.linalg.solve(root, np.broadcast_to(levels[lanes, None], (*root.shape[:-1], 1)))
        total -= np.log(np.diagonal(root, axis1=2, axis2=3)).sum(2) + (white[..., 0] ** 2).sum(2) / 2
    return float(total.max())


def _kernel(place: np.ndarray, length: float, new: float) -> np.ndarray:
    """The covariance of lanes with these numbers in their run, in units of the squared scale; a random walk's
    grows by 1 from lane to lane."""
    if math.isinf(length):
        process = np.minimum.outer(place, place).astype(float)
    else:
        process = np.exp(-np.abs(np.subtract.outer(place, place)) / length)
    return process + new**2 * np.eye(len(place))
