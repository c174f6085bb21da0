"""Least squares over lanes: Levenberg-Marquardt with every lane's start eliminated."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from fitting.lanes import Lanes, Linearisation, Misfit

OUTLIER = 4.0
TRIES = 16
ROUGHLY = 4
NEARBY = 1e-3
MOST_OF_THE_WAY = 0.8
STUCK = 1e8
ROUGHNESS = 0.1
"""A search that finds no lower point has converged if its first step promised less than this share of the
typical cost a sample: events that cross nodes of the grid make the cost rough on that scale."""
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

    def each(self, cost: np.ndarray) -> np.ndarray:
        limit = OUTLIER * self.level * self.dof
        return np.where(cost <= limit, cost, 2 * np.sqrt(limit * cost) - limit)

    def total(self, cost: np.ndarray) -> float:
        return float(np.sum(self.each(cost)))


@dataclasses.dataclass(frozen=True)
class Solution:
    """Where a search ended: coordinates (p), starts (lanes, 3), the linearisation there, the weight of each
    lane, the total cost with priors, which unknowns rest on a bound, and whether it converged."""

    coordinates: np.ndarray
    starts: np.ndarray
    linear: Linearisation
    weights: np.ndarray
    cost: float
    at_bound: np.ndarray
    converged: bool
    history: tuple[float, ...]


@dataclasses.dataclass
class _Search:
    """One search under way: where it is, its linearisation there, its loss, damping and what it has seen."""

    coordinates: np.ndarray
    starts: np.ndarray
    linear: Linearisation
    loss: Robust
    cost: float
    damping: float = 1e-3
    promised: float = 0.0
    at_bound: np.ndarray | None = None
    converged: bool = False
    over: bool = False
    history: list[float] = dataclasses.field(default_factory=list)


def solve(
    misfit: Misfit,
    lanes: Lanes,
    points: np.ndarray,
    starts: np.ndarray,
    *,
    fixed: np.ndarray | None = None,
    robust: Robust | None = None,
    iterations: int = 200,
    tolerance: float = 1e-3,
    progress: Callable[[float], None] = lambda cost: None,
) -> list[Solution]:
    """Minimises the (robust) sum of squares over unknowns within their bounds and over all starts.

    Several searches go side by side: `points` (searches, p) and `starts` (searches, lanes, 3) say where each
    begins. `fixed` marks unknowns to hold. A search has converged when its next step promises to lower the
    cost, in units of the typical cost a sample, by less than `tolerance`: that is a small part of one
    standard deviation of every unknown.
    """
    unknowns = misfit.unknowns
    held = np.zeros(len(unknowns), bool) if fixed is None else fixed
    count, dof = len(lanes), lanes.counted()
    searches = []
    for point, start, linear in zip(
        points, starts, _linearise_all(misfit, lanes, points, starts), strict=True
    ):
        loss = robust or Robust.around(linear.cost, dof)
        cost = loss.total(linear.cost) + unknowns.prior(point)[0]
        searches.append(_Search(point, start, linear, loss, cost, history=[cost]))
    for _ in range(iterations):
        going = [search for search in searches if not search.over]
        if not going:
            break
        steps = [_step(misfit, search, held) for search in going]
        trials = np.array([step.coordinates for step in steps])
        trial_starts = np.array([step.starts for step in steps]).reshape(len(going), count, -1)
        linears = _linearise_all(misfit, lanes, trials, trial_starts)
        for search, step, linear in zip(going, steps, linears, strict=True):
            _judge(search, step, linear, unknowns.prior(step.coordinates)[0], tolerance)
            if robust is None and search.linear is linear:
                search.loss = Robust.around(linear.cost, dof)
                search.cost = search.loss.total(linear.cost) + unknowns.prior(search.coordinates)[0]
        progress(min(search.cost for search in searches))
    return [
        Solution(
            search.coordinates,
            search.starts,
            search.linear,
            search.loss.weights(search.linear.cost),
            search.cost,
            np.zeros(len(unknowns), bool) if search.at_bound is None else search.at_bound,
            search.converged,
            tuple(search.history),
        )
        for search in searches
    ]


def _linearise_all(
    misfit: Misfit, lanes: Lanes, points: np.ndarray, starts: np.ndarray
) -> list[Linearisation]:
    """The linearisations of several searches, from one pass over all their lanes."""
    searches, count = len(points), len(lanes)
    every = lanes.take(np.tile(np.arange(count), searches)) if searches > 1 else lanes
    linear = misfit.linearise(every, np.repeat(points, count, axis=0), starts.reshape(searches * count, -1))
    split = [part.reshape(searches, count, *part.shape[1:]) for part in linear]
    return [Linearisation(*(part[k] for part in split)) for k in range(searches)]


def _judge(search: _Search, step: _Step, linear: Linearisation, prior: float, tolerance: float) -> None:
    """Takes the step if it lowers the cost, sets the damping, and sees whether the search is over."""
    search.at_bound = step.at_bound
    cost = search.loss.total(linear.cost) + prior
    gain = search.cost - cost
    small = tolerance * max(search.loss.level, 1e-300)
    if np.isfinite(cost) and gain > 0:
        search.coordinates, search.starts, search.linear, search.cost = (
            step.coordinates,
            step.starts,
            linear,
            cost,
        )
        search.damping = max(search.damping * (0.1 if gain > 0.5 * step.predicted else 0.5), 1e-9)
        search.promised = 0.0
        search.history.append(cost)
    else:
        search.damping *= 8
        search.promised = max(search.promised, step.predicted)
    search.converged = 0 <= step.predicted < small or 0 < gain < small
    if search.damping > STUCK:
        search.over, search.converged = True, search.promised < ROUGHNESS * search.loss.level
    search.over = search.over or search.converged


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
    found, cost_found = settle(
        misfit, lanes.take(np.tile(stuck, TRIES)), coordinates, tries, iterations=ROUGHLY
    )
    cost_found = cost_found.reshape(TRIES, len(stuck))
    winner, column = np.argmin(cost_found, axis=0), np.arange(len(stuck))
    better = cost_found[winner, column] < 0.95 * cost[stuck]
    if not better.any():
        return None
    starts = starts.copy()
    starts[stuck[better]] = found.reshape(TRIES, len(stuck), 3)[winner, column][better]
    return starts


@dataclasses.dataclass(frozen=True)
class _Step:
    """A damped step: where it leads, the fall of the cost it predicts, and which unknowns stay on a bound."""

    coordinates: np.ndarray
    starts: np.ndarray
    predicted: float
    at_bound: np.ndarray


def _step(misfit: Misfit, search: _Search, held: np.ndarray) -> _Step:
    coordinates, linear, damping = search.coordinates, search.linear, search.damping
    lower, upper = misfit.unknowns.lower, misfit.unknowns.upper
    weights = search.loss.weights(linear.cost)
    p = len(coordinates)
    reduced = reduce(linear, p, damping)
    _, prior_gradient, prior_curvature = misfit.unknowns.prior(coordinates)
    gradient = weights @ reduced.gradient + prior_gradient
    curvature = np.einsum("l,lpq->pq", weights, reduced.curvature) + np.diag(prior_curvature)
    step, active = bounded_step(coordinates, gradient, curvature, damping, held, lower, upper)
    trial = np.clip(coordinates + step, lower, upper)
    start_gain = -np.einsum("l,ls,ls->", weights, linear.gradient[:, p:], reduced.start_step)
    predicted = float(-(2 * gradient @ step + step @ curvature @ step) + start_gain)
    starts = search.starts + reduced.start_step + reduced.start_response @ step
    return _Step(trial, starts, predicted, active)


def bounded_step(
    coordinates: np.ndarray,
    gradient: np.ndarray,
    curvature: np.ndarray,
    damping: float,
    held: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The damped Newton step within the bounds, and which unknowns it leaves on one.

    An unknown that would leave its bounds goes most of the way to the bound, the last of it only from
    nearby, and the others are solved for again.
    """
    step = np.zeros(len(coordinates))
    stopped = np.zeros(len(coordinates), bool)
    damped = curvature + np.diag(damping * np.diag(curvature) + 1e-12)
    for _ in range(len(coordinates)):
        free = ~(held | stopped)
        if not free.any():
            break
        pull = gradient[free] + damped[np.ix_(free, ~free)] @ step[~free]
        step[free] = -np.linalg.solve(damped[np.ix_(free, free)], pull)
        beyond = free & ((coordinates + step < lower) | (coordinates + step > upper))
        if not beyond.any():
            break
        way = np.clip(coordinates + step, lower, upper) - coordinates
        near = np.abs(way) < NEARBY * (upper - lower)
        step = np.where(beyond, np.where(near, way, MOST_OF_THE_WAY * way), step)
        stopped |= beyond
    reached = coordinates + step
    return step, stopped & ((reached <= lower) | (reached >= upper))
