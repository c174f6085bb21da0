"""Lanes caught on the wrong side of an event are freed: settled again from many starts."""

from __future__ import annotations

import dataclasses

import numpy as np

from fitting.diagnosis.model import COLUMNS, Model
from fitting.diagnosis.refit import Bench, Point, Refit, job, normal, refit
from fitting.diagnosis.wander import OWN, START

TRIES = 16
"""So many starts for every lost lane, and together at least `LEAST_TRIES`."""
LEAST_TRIES = 128
SCATTER = (0.1, 0.5, 1.0)
"""Standard deviations of displacement, velocity and force of the new starts, in units of their priors'."""
ITERATIONS = 5
SUSPECT = 4.0
MANY = 0.2
"""Where more than this share of the lanes lies far above, the model is wrong rather than its starts."""
BETTER = 0.9


def released(model: Model, bench: Bench, fit: Refit, seed: int = 0, *, wander: bool = True) -> Refit:
    """The refit with its lost lanes freed and everything fitted once more; the same where none is better.

    Lost are lanes whose cost lies far above the typical one. Each is tried from many starts scattered
    around what the record says, at the unknowns as they are.
    """
    share = fit.cost / bench.dof()
    typical = float(np.median(share))
    lost = np.flatnonzero(share > max(SUSPECT * typical, typical * (1 + 6 * np.sqrt(2 / bench.dof().mean()))))
    if len(lost) == 0 or len(lost) > MANY * len(share):
        return fit
    random = np.random.default_rng(seed)
    tries = max(TRIES, LEAST_TRIES // len(lost))
    part = bench.take(np.tile(lost, tries))
    scattered = np.array(part.lanes.start)
    deviation = np.asarray(part.lanes.start_deviation)[:, :START]
    scattered[:, :START] += np.array(SCATTER) * deviation * random.standard_normal(deviation.shape)
    own, cost = settled(model, part, dataclasses.replace(fit.point, own=scattered))
    cost = cost.reshape(tries, -1)
    winner, column = np.argmin(cost, axis=0), np.arange(len(lost))
    better = cost[winner, column] < BETTER * fit.cost[lost]
    if not better.any():
        return fit
    every = fit.point.own.copy()
    every[lost[better]] = own.reshape(tries, len(lost), OWN)[winner, column][better]
    (again,) = refit(model, bench, [dataclasses.replace(fit.point, own=every)], [fit.free], wander=wander)
    return again if again.misfit < fit.misfit else fit


def borrowed(model: Model, bench: Bench, fit: Refit, other: Refit, near: float = 1.0) -> Refit:
    """The refit, fitted once more with the starts that another hypothesis has for the lanes that it fits far
    better, and with all of them and its constants; the same where neither is better, or where the other
    leaves no less than the share `near` of its misfit."""
    if other.misfit >= near * fit.misfit:
        return fit
    lost = fit.cost > SUSPECT * other.cost
    own = np.where(lost[:, None], other.point.own, fit.point.own)
    common = model.index(*model.common)
    coordinates = fit.point.coordinates.copy()
    coordinates[common] = other.point.coordinates[common]
    points = [
        dataclasses.replace(fit.point, own=own),
        dataclasses.replace(other.point, keys=fit.point.keys, coordinates=coordinates),
    ]
    again = refit(model, bench, points, [fit.free, fit.free])
    return min([fit, *again], key=lambda one: one.misfit)


def settled(
    model: Model, bench: Bench, point: Point, iterations: int = ITERATIONS
) -> tuple[np.ndarray, np.ndarray]:
    """What is best for every lane by itself at given unknowns, and its cost."""
    own, damping = point.own, np.full(len(bench.lanes), 1e-3)
    gradient, curvature, cost = _own_terms(model, bench, point)
    for _ in range(iterations):
        damped = curvature * (1 + damping[:, None, None] * np.eye(OWN))
        trial = own - np.linalg.solve(damped, gradient[:, :, None])[:, :, 0]
        found = _own_terms(model, bench, dataclasses.replace(point, own=trial))
        better = found[2] < cost
        own = np.where(better[:, None], trial, own)
        gradient = np.where(better[:, None], found[0], gradient)
        curvature = np.where(better[:, None, None], found[1], curvature)
        cost = np.where(better, found[2], cost)
        damping = np.clip(np.where(better, 0.1 * damping, 8 * damping), 1e-9, 1e9)
    return own, cost


def _own_terms(model: Model, bench: Bench, point: Point) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    (columns,) = model.columns([job(bench, point)])
    gradient, curvature = normal(columns)
    cost = np.einsum("lr,lr->l", columns.residual, columns.residual)
    return gradient[:, COLUMNS:], curvature[:, COLUMNS:, COLUMNS:], np.where(np.isfinite(cost), cost, 1e30)
