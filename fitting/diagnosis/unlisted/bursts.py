"""Friction that rises for moments: wear particles, debris, patches of transferred material in the contact.

A third body lifts friction while it is between the surfaces and lets go of it afterwards (Godet, Wear 100
(1984) 437). It comes at no phase of the motion and at no place, so that no effect that repeats itself takes
it, and in the mean of a segment it looks like friction that wanders. What tells it is that friction is now
and then far above what it is at that speed, and seldom as far below.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.optimize import least_squares

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Prediction
from fitting.diagnosis.lanes.steadiness import robust_deviation
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly

WINDOW = 0.05
"""Friction is looked at in windows of so much of a natural period,"""
FAST = 0.5
"""in which the mass is faster than this share of the root mean square of its speed in the run: at breakaway
and arrest a model that is slightly off leaves as much."""
FEWEST_WINDOWS = 30
"""So many are needed to say anything of a run."""
FAR = 5.0
"""So many robust standard deviations off is far."""
OFTEN = 0.01
"""It is to be so in more than this share of the windows of a run,"""
ONE_WAY = 2.0
"""and so many times as often that way as the other: a segment in which a burst comes is fitted astray, and
lies below what is usual in what is left of it."""
FEWEST_RUNS = 3
"""It is to rise so in so many runs more than it falls so, and in more than half of all. In 11 of 17 sealed
cases with particles in the contact it did in four to six of six. In 240 without any effect, or with one too
weak to be seen, it did in three of six twice, and else in two at most; another effect may look so to the
nominal model."""
ALTERNATIONS = 3
"""So many times in turn what is usual is fitted and the scale taken of what that leaves."""


@dataclasses.dataclass(frozen=True)
class Bursts(AbstractAnomaly):
    """In how many runs, of how many, friction rises for moments; the share of the time of fast sliding that
    it does so there, and by what share of itself (medians over runs)."""

    runs: int
    of: int
    share: float
    height: float

    @property
    def clause(self) -> str:
        return (
            f"friction rises for moments, by {100 * self.height:.2g} % in {self.runs} of {self.of} runs, as "
            "particles or debris in the contact make it"
        )

    @property
    def note(self) -> str:
        return (
            f"Friction rises for moments in {self.runs} of {self.of} runs, by {100 * self.height:.2g} % of "
            f"itself in {100 * self.share:.2g} % of the time of fast sliding, and seldom falls as far: look "
            "for particles, debris or transferred patches in the contact."
        )

    @property
    def look(self) -> str:
        return (
            "Look at the surfaces and at what lies between them, clean them, and record the same run before "
            "and after: particles, debris and transferred patches go with that, and come back as it wears."
        )

    @property
    def side(self) -> str:
        return "friction"


def bursts(bench: Bench, seen: Prediction, period: float) -> Bursts | None:
    """What there is of bursts in more than half of the runs, None where there is not as much, or no friction
    force. `seen`: what the bench shows under the nominal model; `period`: the natural one [s]."""
    lanes, expected = bench.lanes, seen.friction
    weight = np.asarray(lanes.friction_weight)
    rise = (np.asarray(lanes.friction) - expected) * np.sign(expected)
    size = max(round(WINDOW * bench.samples(period)), 2)
    windows = [_windowed(values, size) for values in (rise, np.abs(expected), seen.velocity, weight)]
    found, looked_at, falls = [], 0, 0
    for run in np.unique(bench.run):
        mine = [values[bench.run == run].reshape(-1, size) for values in windows]
        counted = np.all(mine[3] > 0, axis=1)
        if not counted.any():
            continue
        looked_at += 1
        above = _above(*(values[counted] for values in mine[:3]))
        if not len(above):
            continue
        limit = FAR * robust_deviation(above)
        high, low = above > limit, above < -limit
        if _mostly(high, low):
            found.append((high.mean(), np.median(above[high])))
        falls += _mostly(low, high)
    if len(found) - falls < FEWEST_RUNS or 2 * len(found) <= looked_at:
        return None
    share, height = np.median(found, axis=0)
    return Bursts(len(found), looked_at, float(share), float(height))


def _windowed(values: np.ndarray, size: int) -> np.ndarray:
    """Values (lanes, samples) in windows (lanes, windows, size), without what is left over at the end."""
    whole = values.shape[1] // size
    return values[:, : whole * size].reshape(len(values), whole, size)


def _above(rise: np.ndarray, friction: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """How far friction rises above what is usual in the windows (windows, samples) of fast sliding, as a
    share of what it is there (median); none where these are few."""
    speed = np.abs(velocity)
    fast = speed.min(axis=1) > FAST * np.sqrt(np.mean(velocity**2))
    if fast.sum() < FEWEST_WINDOWS:
        return np.zeros(0)
    above = _above_usual(rise[fast].mean(axis=1), velocity[fast].mean(axis=1))
    return above / np.median(friction[fast].mean(axis=1))


def _mostly(far: np.ndarray, other_way: np.ndarray) -> bool:
    """Whether friction is far off one way often in the windows of a run, and that way rather than the
    other."""
    return bool(far.mean() > OFTEN and far.mean() >= ONE_WAY * other_way.mean())


def _above_usual(rise: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """How far it rises above what it usually does at that speed in that direction: a parabola by robust
    regression, whose scale is that of what it leaves."""
    sense, speed = np.sign(velocity), np.abs(velocity) / np.max(np.abs(velocity))
    design = np.stack([np.ones_like(speed), speed, speed**2, sense, sense * speed], axis=1)
    coefficients = np.array([np.median(rise), 0.0, 0.0, 0.0, 0.0])
    left = rise - design @ coefficients
    for _ in range(ALTERNATIONS):
        scale = max(robust_deviation(left), 1e-300)
        solution = least_squares(
            lambda values, scale=scale: (rise - design @ values) / scale,
            coefficients,
            jac=lambda values, scale=scale: -design / scale,  # pyright: ignore[reportArgumentType]
            loss="cauchy",
        )
        coefficients = solution.x
        left = rise - design @ coefficients
    return left
