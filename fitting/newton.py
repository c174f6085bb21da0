"""Least squares over lanes: Levenberg-Marquardt with every lane's start eliminated."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from fitting.lanes import Lanes, Linearisation, Misfit

OUTLIER = 4.0
TRIES = 16
SCATTER = np.array([0.3, 0.5, 1.0])


@dataclasses.dataclass(frozen=True)
class Reduced:
    """Normal equations in the unknowns after eliminating the starts, per lane: gradient (lanes, p) and
    curvature (lanes, p, p), and the maps that give the starts back."""

    gradient: np.ndarray
    curvature: np.ndarray
    start_step: np.ndarray
    start_response: np.ndarray


def reduce(linear: Linearisation, unknowns: int, damping: float | np.ndarray = 0.0) -> Reduced:
    """Eliminates the starts lane by lane (Schur complement), their own curvature damped by `damping`."""
    p = unknowns
    gradient, curvature = linear.gradient, linear.curvature
    own = curvature[:, p:, p:]
    own = own + damping * own * np.eye(own.shape[-1])
    coupling = curvature[:, p:, :p]
    response = np.linalg.solve(own, np.concatenate([gradient[:, p:, None], coupling], axis=2))
    step, slope = -response[:, :, 0], -response[:, :, 1:]
    return Reduced(
        gradient[:, :p] + np.einsum("lsp,ls->lp", coupling, step),
        curvature[:, :p, :p] + np.einsum("lsp,lsq->lpq", coupling, slope),
        step,
        slope,
    )


@dataclasses.dataclass(frozen=True)
class Robust:
    """A Huber loss on each lane's root cost, so that a few bad segments do not decide.

    `dof` samples a lane; a lane counts fully up to `OUTLIER` times `level`, the typical cost a sample.
    """

    dof: np.ndarray
    level: float

    @classmethod
    def around(cls, cost: np.ndarray, dof: np.ndarray) -> Robust:
        return cls(dof, float(np.median(cost / dof)))

    def weights(self, cost: np.ndarray) -> np.ndarray:
        limit = OUTLIER * self.level * self.dof
        return np.sqrt(np.minimum(1.0, limit / np.maximum(cost, 1e-300)))

    def total(self, cost: np.ndarray) -> float:
        limit = OUTLIER * self.level * self.dof
        return float(np.sum(np.where(cost <= limit, cost, 2 * np.sqrt(limit * cost) - limit)))


@dataclasses.dataclass(frozen=True)
class Solution:
    """Where the least-squares search ended: coordinates (p), starts (lanes, 3), the linearisation there, the
    weight of each lane, the total cost with priors, which unknowns rest on a bound, and whether it converged."""

    coordinates: np.ndarray
    starts: np.ndarray
    linear: Linearisation
    weights: np.ndarray
    cost: float
    at_bound: np.ndarray
    converged: bool
    history: tuple[float, ...]


def solve(
    misfit: Misfit,
    lanes: Lanes,
    coordinates: np.ndarray,
    starts: np.ndarray,
    *,
    fixed: np.ndarray | None = None,
    robust: Robust | None = None,
    iterations: int = 100,
    tolerance: float = 1e-3,
    progress: Callable[[float], None] = lambda cost: None,
) -> Solution:
    """Minimises the (robust) sum of squares over unknowns within their bounds and over all starts.

    `fixed` marks unknowns to hold. Converged when a full step would move no unknown by more than `tolerance`
    of its standard deviation.. or the cost by less than `tolerance`.
    """
    unknowns = misfit.unknowns
    p = len(unknowns)
    held = np.zeros(p, bool) if fixed is None else fixed
    dof = lanes.counted()
    lower, upper = unknowns.lower, unknowns.upper
    each = np.ones((len(lanes), 1))
    linear = misfit.linearise(lanes, each * coordinates, starts)
    loss = robust or Robust.around(linear.cost, dof)
    cost = loss.total(linear.cost) + unknowns.prior(coordinates)[0]
    damping, converged, history = 1e-3, False, [cost]
    at_bound = np.zeros(p, bool)
    for _ in range(iterations):
        weights = loss.weights(linear.cost)
        step, start_step, predicted, at_bound = _step(
            misfit, linear, weights, coordinates, held, damping, lower, upper
        )
        trial = np.clip(coordinates + step, lower, upper)
        trial_starts = starts + start_step
        trial_linear = misfit.linearise(lanes, each * trial, trial_starts)
        trial_cost = loss.total(trial_linear.cost) + unknowns.prior(trial)[0]
        gain = cost - trial_cost
        if np.isfinite(trial_cost) and gain > 0:
            coordinates, starts, linear = trial, trial_starts, trial_linear
            damping = max(damping * (0.1 if gain > 0.5 * predicted else 0.5), 1e-9)
            if robust is None:
                loss = Robust.around(linear.cost, dof)
            cost = loss.total(linear.cost) + unknowns.prior(coordinates)[0]
            history.append(cost)
            progress(cost)
        else:
            damping *= 8
        if predicted < tolerance * max(1.0, loss.level) or (0 < gain < tolerance * max(1.0, loss.level)):
            converged = True
            break
        if damping > 1e8:
            converged = predicted < 1e-2 * loss.level
            break
    return Solution(
        coordinates, starts, linear, loss.weights(linear.cost), cost, at_bound, converged, tuple(history)
    )


def settle(
    misfit: Misfit, lanes: Lanes, coordinates: np.ndarray, starts: np.ndarray, iterations: int = 10
) -> tuple[np.ndarray, np.ndarray]:
    """The best starts at given unknowns, each lane on its own, and each lane's cost."""
    p = len(misfit.unknowns)
    each = np.broadcast_to(coordinates, (len(lanes), p))
    linear = misfit.linearise(lanes, each, starts)
    cost = linear.cost
    damping = np.full(len(lanes), 1e-3)
    for _ in range(iterations):
        trial = starts + reduce(linear, p, damping[:, None, None]).start_step
        trial_linear = misfit.linearise(lanes, each, trial)
        better = trial_linear.cost < cost
        gain = np.where(better, cost - trial_linear.cost, 0.0)
        starts = np.where(better[:, None], trial, starts)
        linear = Linearisation(
            *(
                np.where(better.reshape(-1, *[1] * (new.ndim - 1)), new, old)
                for new, old in zip(trial_linear, linear, strict=True)
            )
        )
        cost = linear.cost
        damping = np.clip(np.where(better, damping * 0.1, damping * 8), 1e-9, 1e9)
        if np.all(gain < 1e-6 * cost) and np.all(better | (damping > 1e3)):
            break
    return starts, cost


def unstick(
    misfit: Misfit, lanes: Lanes, coordinates: np.ndarray, starts: np.ndarray, cost: np.ndarray, seed: int = 0
) -> np.ndarray | None:
    """Better starts for the lanes that fit far worse than the rest; None where none is found.

    A lane may be caught on the wrong side of an event (a slip missed or invented). Each lane whose cost lies
    six standard deviations above the median is settled again from `TRIES` starts scattered around its prior.
    """
    dof = lanes.counted()
    share = cost / dof
    stuck = np.flatnonzero(share > np.median(share) * (1 + 6 * np.sqrt(2 / dof)))
    if len(stuck) == 0:
        return None
    random = np.random.default_rng(seed)
    prior, deviation = np.asarray(lanes.start)[stuck], np.asarray(lanes.start_deviation)[stuck]
    scatter = SCATTER * random.standard_normal((TRIES, len(stuck), 3))
    tries = (prior + scatter * deviation).reshape(-1, 3)
    found, cost_found = settle(misfit, lanes.take(np.tile(stuck, TRIES)), coordinates, tries)
    cost_found = cost_found.reshape(TRIES, len(stuck))
    winner, column = np.argmin(cost_found, axis=0), np.arange(len(stuck))
    better = cost_found[winner, column] < 0.95 * cost[stuck]
    if not better.any():
        return None
    starts = starts.copy()
    starts[stuck[better]] = found.reshape(TRIES, len(stuck), 3)[winner, column][better]
    return starts


def _step(
    misfit: Misfit,
    linear: Linearisation,
    weights: np.ndarray,
    coordinates: np.ndarray,
    held: np.ndarray,
    damping: float,
    lower: np.ndarray,
    upper: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
    """One damped step: of the unknowns, of the starts, the fall of the cost it predicts, and active bounds."""
    p = len(coordinates)
    reduced = reduce(linear, p, damping)
    _, prior_gradient, prior_curvature = misfit.unknowns.prior(coordinates)
    gradient = weights @ reduced.gradient + prior_gradient
    curvature = np.einsum("l,lpq->pq", weights, reduced.curvature) + np.diag(prior_curvature)
    active = ((coordinates <= lower) & (gradient > 0)) | ((coordinates >= upper) & (gradient < 0))
    step = np.zeros(p)
    for _ in range(p):
        free = ~(held | active)
        if not free.any():
            break
        block = curvature[np.ix_(free, free)]
        block = block + np.diag(damping * np.diag(block) + 1e-12)
        step = np.zeros(p)
        step[free] = -np.linalg.solve(block, gradient[free])
        blocked = free & (((coordinates <= lower) & (step < 0)) | ((coordinates >= upper) & (step > 0)))
        if not blocked.any():
            break
        active |= blocked
    step = np.clip(coordinates + step, lower, upper) - coordinates
    start_step = reduced.start_step + reduced.start_response @ step
    start_gain = -np.einsum("l,ls,ls->", weights, linear.gradient[:, p:], reduced.start_step)
    predicted = float(-(2 * gradient @ step + step @ curvature @ step) + start_gain)
    return step, start_step, predicted, active & ~held
