"""Friction that scatters moves the mass: what it does to the displacement is known from the force.

Whatever friction does, m x'' + c x' + K x changes by what the friction force changes by. Scatter with the
covariance Q of the force thus shows in displacement and force together, with the covariance [H; I] Q [H; I]'
(H: the response of the free rig to a force), and in the equation of motion closed with the measured force it
cancels. Residuals are weighed by all of that (generalised least squares), so that faults of the mechanics
stand out from friction that scatters. Source: Aitken, Proc. Royal Society of Edinburgh 55 (1936) 42.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import expm, get_lapack_funcs

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model

REMEMBERED = 0.15
"""Friction that scatters is taken to remember for this share of the natural period."""
MOST_ROWS = 640
"""Longer lanes are weighed row by row: matrices as large as their square would fill the memory."""


def whitener(
    model: Model, bench: Bench, point: Point, scatter: np.ndarray, period: float
) -> np.ndarray | None:
    """Matrices (lanes, rows, rows) that free residuals of displacement and friction, weighed by noise, of
    scatter. `scatter` (lanes, samples): the standard deviation of the friction force [N] but for noise. None
    where lanes are too long, or have no friction recorded."""
    count, samples = scatter.shape
    weights, root = bench.lanes.weights(), np.sqrt(bench.share)
    counts = weights > 0
    if 2 * samples > MOST_ROWS or not counts[:, :, 1].any():
        return None
    exact = np.where(counts, weights / np.where(counts, root, 1.0), 0.0)
    out = np.empty((count, 2 * samples, 2 * samples))
    known = list(_per_lane(model, bench, point, period))

    def fill(lane: int) -> None:
        free = _freed(exact[lane].T, scatter[lane], *known[lane])
        kept = root[lane].T.ravel()
        plain = np.divide(1.0, kept, out=np.zeros_like(kept), where=kept > 0)
        out[lane] = kept[:, None] * free * plain

    model.side_by_side(fill, range(count))
    return out


def _freed(exact: np.ndarray, scatter: np.ndarray, moves: np.ndarray, alike: np.ndarray) -> np.ndarray:
    """The matrix that frees displacement, the first half of the rows, of what friction, the second half, says
    of it, and both of what they remember; what it makes of noise and scatter together is one.

    It is the inverse of the lower Cholesky factor of their covariance with friction first. `exact` (2,
    samples): one over the noise of displacement and friction.
    """
    samples = len(scatter)
    x, f = exact[:, :, None]
    force = scatter[:, None] * alike * scatter
    moved = moves @ force
    covariance = np.eye(2 * samples)
    covariance[:samples, :samples] += f * force * f.T
    covariance[samples:, :samples] = x * moved * f.T
    covariance[samples:, samples:] += x * (moved @ moves.T) * x.T
    root = np.linalg.cholesky(covariance)
    (inverted,) = get_lapack_funcs(("trtri",), (root,))
    inverse, _ = inverted(root, lower=1)
    return np.roll(inverse, samples, axis=(0, 1))


def _per_lane(
    model: Model, bench: Bench, point: Point, period: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Response of the displacement to the force, and correlation of the force, (samples, samples) each, lane
    by lane."""
    samples = bench.lanes.displacement.shape[1]
    known: dict[tuple[float, ...], tuple[np.ndarray, np.ndarray]] = {}
    intervals = np.asarray(bench.lanes.interval).tolist()
    for interval, rig in zip(intervals, rigs_of(model, bench, point), strict=True):
        key = interval, *rig
        if key not in known:
            age = interval * np.abs(np.subtract.outer(np.arange(samples), np.arange(samples)))
            known[key] = response(*key, samples), np.exp(-age / (REMEMBERED * period))
        yield known[key]


def rigs_of(model: Model, bench: Bench, point: Point) -> list[tuple[float, float, float]]:
    """Mass [kg], stiffness [N/m] and damping [N s/m] of the rig without any effect, lane by lane."""
    rig, shifts = model.at(point.coordinates, ()).nominal.rig, bench.lanes.rig_shift
    shifted = [
        float(getattr(rig, name)) + np.asarray(shifts.get(name, np.zeros(len(bench.lanes))))
        for name in ("mass", "stiffness", "damping")
    ]
    return [(mass, stiffness, damping) for mass, stiffness, damping in np.stack(shifted, axis=1).tolist()]


def response(interval: float, mass: float, stiffness: float, damping: float, samples: int) -> np.ndarray:
    """By how much the displacement at each sample [m] answers a force on the mass at each [N], from rest
    (samples, samples). Between two samples half of either force acts."""
    system = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1 / mass], [0.0, 0.0, 0.0]])
    step = expm(system * interval)
    after, before = np.zeros(samples), np.zeros(samples)
    state = step[:2, 2] / 2
    for lag in range(samples):
        before[lag] = state[0]
        after[lag + 1 : lag + 2] = state[0]
        state = step[:2, :2] @ state
    lag = np.subtract.outer(np.arange(samples), np.arange(samples))
    out = np.where(lag >= 0, (after + before)[np.abs(lag)], 0.0)
    out[:, 0] = after
    return out
