"""Intervals of the free parameters: from the covariance where it tells, else from the profile."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fitting.lanes import Lanes, Misfit
from fitting.newton import Robust, Solution, solve
from fitting.uncertainty import Spread

NEARLY_LINEAR = 0.3
LARGEST_STEPS = 10


@dataclasses.dataclass(frozen=True)
class Interval:
    """A 95 % interval in coordinates; an end is None where the data do not bound the parameter on that side.

    `method` is "covariance" or "profile".
    """

    low: float | None
    high: float | None
    deviation: float
    method: str


def interval(
    misfit: Misfit,
    lanes: Lanes,
    solution: Solution,
    robust: Robust,
    spread: Spread,
    index: int,
) -> Interval:
    """The interval of the unknown at `index`.

    The covariance serves where the unknown keeps clear of its bounds and its logarithm is known to 0.3;
    otherwise the profile of the cost is followed outwards until it has risen by t^2 times the inflation of
    the variance over that of white residuals.
    """
    unknown = misfit.unknowns.members[index]
    at = float(solution.coordinates[index])
    bounds = float(misfit.unknowns.lower[index]), float(misfit.unknowns.upper[index])
    deviation = float(spread.deviation()[index])
    reach = float(spread.quantile()[index]) * deviation
    relative = deviation if unknown.kind == "log" else deviation / max(abs(at), 1e-300)
    clear = at - 1.3 * reach > bounds[0] and at + 1.3 * reach < bounds[1]
    if clear and (relative < NEARLY_LINEAR or unknown.lower < 0):
        return Interval(at - reach, at + reach, deviation, "covariance")
    threshold = float(spread.quantile()[index]) ** 2 * float(max(spread.inflation()[index], 1e-12))
    ends = [_crossing(misfit, lanes, solution, robust, index, bound, reach, threshold) for bound in bounds]
    return Interval(ends[0], ends[1], deviation, "profile")


def _crossing(
    misfit: Misfit,
    lanes: Lanes,
    solution: Solution,
    robust: Robust,
    index: int,
    bound: float,
    reach: float,
    threshold: float,
) -> float | None:
    """Where the profile crosses the threshold on the way to `bound`; None where it does not, or where the
    other unknowns cannot be settled on the way.

    The root of the rise in cost is nearly linear, so a crossing is interpolated once it is bracketed by a
    point that overshoots by no more than a factor of two; a point that overshoots by more is drawn nearer.
    """
    at = float(solution.coordinates[index])
    sense = 1.0 if bound > at else -1.0
    fixed = np.zeros(len(misfit.unknowns), bool)
    fixed[index] = True
    coordinates, starts = solution.coordinates, solution.starts
    target = math.sqrt(threshold)
    inner, inner_root, nearest = at, 0.0, None
    step = reach if math.isfinite(reach) and reach > 0 else abs(bound - at)
    for _ in range(LARGEST_STEPS):
        outer = bound if abs(bound - inner) <= step else inner + sense * step
        if outer == inner:
            return None
        point = coordinates.copy()
        point[index] = outer
        (found,) = solve(
            misfit,
            lanes,
            point[None],
            starts[None],
            fixed=fixed,
            robust=robust,
            iterations=25,
            tolerance=1e-2,
        )
        if not found.converged:
            return nearest
        root = math.sqrt(max(found.cost - solution.cost, 0.0))
        if root >= target:
            share = (target - inner_root) / max(root - inner_root, 1e-300)
            if root <= 2 * target:
                return inner + share * (outer - inner)
            nearest = outer
            step = max(1.5 * share, 0.1) * abs(outer - inner)
            continue
        if outer == bound:
            return None
        coordinates, starts = found.coordinates, found.starts
        inner, inner_root = outer, root
        step = max(1.3 * (target - root) * abs(outer - at) / max(root, 1e-3 * target), 0.3 * step)
        if nearest is not None:
            step = min(step, 0.5 * abs(nearest - inner))
    return nearest
