"""A first guess of the constants, read nearly directly from F against v in slip and F against x in stick."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from fitting.signals import Signals


@dataclasses.dataclass(frozen=True)
class Scales:
    """The sizes of things in a data set: friction force [N], sliding speed [m/s], displacement [m]."""

    force: float
    speed: float
    displacement: float


def scales(signals: Sequence[Signals]) -> Scales:
    """Sizes from the upper end of what the runs show."""
    friction = np.concatenate([np.abs(signal.friction) for signal in signals])
    speed = np.concatenate([np.abs(signal.slide_rate) for signal in signals])
    stroke = max(np.ptp(signal.run.displacement) for signal in signals)
    has_force = signals[0].run.friction is not None
    return Scales(
        float(np.quantile(friction, 0.999 if has_force else 0.9)),
        float(np.quantile(speed, 0.999)),
        float(stroke / 2),
    )


def opening(signals: Sequence[Signals], scale: Scales) -> dict[str, float]:
    """A, B, C, D by robust least squares of |F| against |v| in slip; k1 from F against x near standstill.

    Slip is where |v| exceeds both 5 % of the top speed and 6 of its standard deviations; the friction that
    opposes the motion there is the law's.
    """
    speed, force = _slip(signals, scale)
    unit = np.array([scale.force, 1 / scale.speed, scale.force, scale.force / scale.speed])

    def misfit(point: np.ndarray) -> np.ndarray:
        a, b, c, d = point * unit
        return (a * np.exp(-b * speed) + c + d * speed - force) / scale.force

    best = min(
        (
            least_squares(
                misfit,
                [0.2, decay, 0.7, 0.01],
                bounds=([0, 2, 0, 0], [3, 300, 3, 3]),
                loss="soft_l1",
                f_scale=0.05,
            )
            for decay in (3.0, 10.0, 30.0)
        ),
        key=lambda result: result.cost,
    )
    a, b, c, d = best.x * unit
    return {"A": float(a), "B": float(b), "C": float(c), "D": float(d), "k1": _stick_slope(signals, scale)}


def _slip(signals: Sequence[Signals], scale: Scales) -> tuple[np.ndarray, np.ndarray]:
    speeds, forces = [], []
    for signal in signals:
        moving = np.abs(signal.slide_rate) > max(0.05 * scale.speed, 6 * signal.velocity_deviation)
        speeds.append(np.abs(signal.slide_rate[moving]))
        forces.append(-np.sign(signal.slide_rate[moving]) * signal.friction[moving])
    speed, force = np.concatenate(speeds), np.concatenate(forces)
    if len(speed) < 8:
        return np.array([scale.speed, scale.speed]), np.array([scale.force, scale.force])
    return speed, force


def _stick_slope(signals: Sequence[Signals], scale: Scales) -> float:
    """-dF/dx over short stretches near standstill: the median of slopes weighted by the travel they span."""
    slopes, weights = [], []
    for signal in signals:
        slow = np.abs(signal.slide_rate) < max(0.05 * scale.speed, 4 * signal.velocity_deviation)
        x, force = signal.slide, signal.friction
        edges = np.flatnonzero(np.diff(np.concatenate([[0], slow.astype(int), [0]])))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            if last - first < 6:
                continue
            travel = x[first:last] - x[first:last].mean()
            load = force[first:last] - force[first:last].mean()
            excess = travel @ travel - (last - first) * signal.displacement_noise**2
            if excess > 0 and np.ptp(load) < 2.5 * scale.force:
                slopes.append(-(travel @ load) / excess)
                weights.append(excess)
    slope = np.array(slopes)
    good = slope > 0
    if good.sum() < 3:
        return 50 * scale.force / scale.displacement
    order = np.argsort(slope[good])
    cumulative = np.cumsum(np.array(weights)[good][order])
    return float(slope[good][order][np.searchsorted(cumulative, cumulative[-1] / 2)])
