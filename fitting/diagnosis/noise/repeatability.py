"""What does not repeat itself: residuals that differ from one cycle of the excitation to the next.

A deterministic model, right or wrong, leaves the same residual in every cycle of a periodic motion. What
differs between cycles, noise and friction that scatters, is the misfit that no effect can take away: the pure
error of a test for lack of fit with replicates (Draper, Smith, Applied Regression Analysis, 3rd ed., 1998,
section 2.1). What changes by as much from every cycle to the next drifts, and does not count.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.cost import misfit_of
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import OWN
from fitting.diagnosis.refits.refit import Refit

FEWEST = 6
"""Pairs of lanes in successive cycles below which nothing is said."""
FEWEST_CYCLES = 4
"""So many changes from cycle to cycle tell what drifts from what scatters."""
UNEVEN = 2.0
"""Scatter is no more uneven among lanes than this, mean to median: more is something that acts in a few."""
LEAST = 0.1
"""Nothing is overrated by more than this."""
A_GOOD_DEAL = 0.002
"""Friction that wanders by less, as a share of itself, hides nothing and scatters little."""


def wander_of(fit: Refit) -> float:
    """By how many percent friction wanders from segment to segment (standard deviation)."""
    return 100 * math.sqrt(fit.misfit) * float(np.hypot(*fit.point.widths))


def wanders(fit: Refit) -> bool:
    """Whether a hypothesis lets friction wander by a good deal."""
    return float(fit.point.widths.max()) * math.sqrt(fit.misfit) > A_GOOD_DEAL


def floor_of(model: Model, bench: Bench, fits: Sequence[Refit]) -> float:
    """The least misfit that any model can have here: `unrepeated` with what the wandering of friction costs
    in likelihood, as every misfit has it. Where residuals are weighed by what does not repeat itself, which
    may be overrated, it may be less than 1."""
    least = LEAST if bench.scatters else 1.0
    return _least(model, bench, fits, [fit.price(bench) for fit in fits], least)


def unrepeated(model: Model, bench: Bench, fits: Sequence[Refit]) -> float:
    """The least chi-square per degree of freedom, 1 at least in units of the noise: of several fits the
    lowest mean square of what changes from one cycle to the next, outliers weighed down, and no more than
    `UNEVEN` times what a typical lane costs.

    1 where the lanes are not repeated, and where friction keeps still under one of the fits: an effect that
    keeps another time than the excitation does not repeat itself either, and is no scatter. Where the
    friction force was not recorded, so that nothing tells whether it keeps still, lanes count that come back
    often enough to tell what scatters from what drifts.
    """
    return _least(model, bench, fits, [1.0] * len(fits), 1.0)


def _least(model: Model, bench: Bench, fits: Sequence[Refit], prices: Sequence[float], least: float) -> float:
    first, second = successive(bench.phase)
    if not bench.wanders:
        label = bench.phase[first]
        told = np.bincount(label)[label] >= FEWEST_CYCLES
        first, second = first[told], second[told]
    elif least == 1 and not all(wanders(fit) for fit in fits):
        return 1.0
    if len(first) < FEWEST:
        return 1.0
    dof = bench.dof()
    changing, typical = [], []
    seen = model.columns([job(model, bench, fit.point) for fit in fits])
    for fit, columns, price in zip(fits, seen, prices, strict=True):
        changing.append(price * _pure_error(bench, columns.residual[:, :-OWN], first, second))
        typical.append(price * float(np.median(fit.cost / dof)))
    return max(least, min(*changing, UNEVEN * min(typical)))


def successive(phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of lanes with the same phase in successive cycles; lanes are in the order of time."""
    last: dict[int, int] = {}
    pairs = []
    for lane, label in enumerate(phase.tolist()):
        if label < 0:
            continue
        if label in last:
            pairs.append((last[label], lane))
        last[label] = lane
    return tuple(np.array(pairs, int).reshape(-1, 2).T)  # pyright: ignore[reportReturnType]


def _pure_error(bench: Bench, residual: np.ndarray, first: np.ndarray, second: np.ndarray) -> float:
    """Half the mean square difference between the residuals of paired lanes, as a misfit."""
    squares, noise = differences(bench, residual, first, second)
    return misfit_of(squares.sum((1, 2)), np.maximum(noise.sum((1, 2)) - 3, 1))


def differences(
    bench: Bench, residual: np.ndarray, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Half the squared differences between the residuals of paired lanes (pairs, channels, samples), less
    what they have in common with those of the same phase in other cycles; and what noise alone makes of
    them. `residual` (lanes, rows): displacement, then friction."""
    share = bench.share.transpose(0, 2, 1)
    residual = residual.reshape(share.shape)
    both = (share[first] > 0) & (share[second] > 0)
    change = np.where(both, residual[first] - residual[second], 0.0)
    squares = np.empty_like(change)
    label = bench.phase[first]
    for phase in np.unique(label):
        mine = label == phase
        count = both[mine].sum(0)
        mean = change[mine].sum(0) / np.maximum(count, 1)
        drifts = count >= FEWEST_CYCLES
        left = change[mine] - np.where(drifts, mean, 0.0)
        squares[mine] = left**2 / 2 * np.where(drifts, count / np.maximum(count - 1, 1), 1.0)
    return np.where(both, squares, 0.0), np.where(both, (share[first] + share[second]) / 2, 0.0)
