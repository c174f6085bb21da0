"""Gradient descent on the constants from several starts at once, in an optax loop."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import jax
import numpy as np
import optax

from fitting.lanes import Lanes, Misfit
from fitting.newton import reduce

TOLERANCE = 4.0
START_STEP = 3.0


@dataclasses.dataclass(frozen=True)
class Descent:
    """Where each of several descents ended: coordinates (starts, p), mean loss, and the loss on the way
    (iterations, starts)."""

    coordinates: np.ndarray
    loss: np.ndarray
    history: np.ndarray


def descend(
    misfit: Misfit,
    lanes: Lanes,
    points: np.ndarray,
    *,
    iterations: int,
    learning_rate: float = 0.25,
    progress: Callable[[float], None] = lambda loss: None,
) -> Descent:
    """Descends from every row of `points` (starts, p) over all lanes together by Adam with a falling rate.

    The loss is the mean over lanes of ln(1 + chi^2/(4 dof)), which a segment that missed a slip cannot
    dominate. The gradient is taken with the lanes' own starts eliminated, and these follow by damped Newton
    steps (variable projection). Coordinates are stretched to infinity at their bounds.
    """
    unknowns = misfit.unknowns
    k, count = len(points), len(lanes)
    each = lanes.take(np.tile(np.arange(count), k))
    dof = each.counted()
    starts = np.tile(np.asarray(lanes.start), (k, 1))
    room = START_STEP * np.asarray(each.start_deviation)
    schedule = optax.cosine_decay_schedule(learning_rate, iterations)
    optimiser = optax.adam(schedule, b1=0.8, b2=0.95)
    stretched = unknowns.to_unbounded(np.clip(points, unknowns.lower, unknowns.upper))
    best = np.full(k, np.inf)
    best_point = np.array(points, float)
    history = []
    with jax.enable_x64(True):
        state = optimiser.init(stretched)
    for _ in range(iterations):
        coordinates, slope = unknowns.from_unbounded(stretched)
        linear = misfit.linearise(each, np.repeat(coordinates, count, axis=0), starts)
        excess = linear.cost / (TOLERANCE * dof)
        loss = np.log1p(np.nan_to_num(excess, nan=1e12)).reshape(k, count).mean(1)
        better = loss < best
        best, best_point = np.where(better, loss, best), np.where(better[:, None], coordinates, best_point)
        history.append(loss)
        progress(float(best.min()))
        weights = 1 / (TOLERANCE * dof * (1 + excess)) / count
        reduced = reduce(linear, len(unknowns), damping=0.1)
        gradient = np.einsum("kl,klp->kp", weights.reshape(k, count), reduced.gradient.reshape(k, count, -1))
        with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
            update, state = optimiser.update(np.nan_to_num(gradient * slope), state)
        stretched = stretched + np.asarray(update)
        step = np.nan_to_num(reduced.start_step)
        starts = starts + np.clip(step, -room, room)
    return Descent(best_point, best, np.array(history))
