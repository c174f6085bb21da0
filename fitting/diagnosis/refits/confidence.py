"""How sure the parameters of a refit are: intervals that stay right when residuals are coloured."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.between_runs import deviation_of_runs, uncertainty_of_mean
from fitting.diagnosis.lanes.equations import Projection
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.layout import LEVELLED, Layout
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit

CLUSTER = 3
"""So many neighbouring lanes of a run share their errors."""
LEVEL = 0.95


class Deviations(NamedTuple):
    """Standard deviations of the free coordinates of a refit, the Student quantile that goes with them, and
    the standard deviation of friction between runs as a share of itself, which those of the constants that
    it multiplies contain."""

    spread: np.ndarray
    quantile: float
    between_runs: float


def deviations(model: Model, bench: Bench, found: Refit) -> Deviations:
    """How sure the free coordinates of a refit are.

    The covariance is H^-1 (sum over clusters of g_c g_c') H^-1 with the scores g_c of neighbouring lanes
    summed, times C/(C - 1) for C clusters; never below that of white residuals of the size that is left.
    Where friction differs from run to run, what n runs leave open of its mean is added to that.
    """
    seen = _of_fit(model, bench, found)
    layout = Layout.of(model, bench, found.free)
    inverse = np.linalg.inv(_information(model, bench, found, seen))
    cluster = _clusters(bench)
    total = np.zeros_like(inverse)
    for number in range(cluster.max() + 1):
        mine = np.flatnonzero(cluster == number)
        score, _ = layout.summed(bench.run[mine], seen.gradient[mine], seen.curvature[mine])
        total += np.outer(score, score)
    count = cluster.max() + 1
    robust = np.diag(inverse @ total @ inverse) * count / max(count - 1, 1)
    white = np.diag(inverse) * max(found.misfit, 1.0)
    variance = np.maximum(robust, white)
    quantile = float(student.ppf(0.5 + LEVEL / 2, max(count - len(found.free), 2)))
    runs = layout.runs
    between = deviation_of_runs(found.point.by_run[runs, 0], variance[layout.index[runs, 0]])
    of_mean = uncertainty_of_mean(between, len(runs), LEVEL, quantile)
    multiplied = of_mean * _slopes(model, found)
    return Deviations(np.sqrt(variance[layout.of_free] + multiplied**2), quantile, between)


def _slopes(model: Model, found: Refit) -> np.ndarray:
    """By how much the free coordinates change with the logarithm of friction."""
    slopes = np.zeros(len(found.free))
    for number in model.index(*LEVELLED):
        logarithmic = model.members[number].kind == "log"
        slopes[found.free == number] = 1.0 if logarithmic else found.point.coordinates[number]
    return slopes


def information(model: Model, bench: Bench, found: Refit) -> np.ndarray:
    """Half the curvature of chi-square and prior over what a refit has free, in the order of its `Layout`."""
    return _information(model, bench, found, _of_fit(model, bench, found))


def step_to_optimum(model: Model, bench: Bench, found: Refit) -> np.ndarray:
    """The Gauss-Newton step of the free coordinates of a refit to the optimum on this bench."""
    seen = _of_fit(model, bench, found)
    layout = Layout.of(model, bench, found.free)
    gradient, _ = layout.summed(bench.run, seen.gradient, seen.curvature)
    gradient = gradient + layout.prior(model, found.point).gradient
    return -np.linalg.solve(_information(model, bench, found, seen), gradient)[layout.of_free]


class Scores(NamedTuple):
    """J'r (lanes, columns) and J'J (lanes, columns, columns) of level and free unknowns, and r'r of every
    lane, what each has of its own eliminated."""

    gradient: np.ndarray
    curvature: np.ndarray
    cost: np.ndarray


def scores(model: Model, bench: Bench, point: Point, free: np.ndarray) -> Scores:
    """The scores of a bench's lanes at a point."""
    (columns,) = model.columns([job(model, bench, point, free)])
    wanted = [columns.jacobian[:, :, : 1 + len(free)], columns.residual[:, :, None]]
    own = Projection(columns)(np.concatenate(wanted, axis=2))
    products = own.transpose(0, 2, 1) @ own
    return Scores(products[:, :-1, -1], products[:, :-1, :-1], products[:, -1, -1])


def _of_fit(model: Model, bench: Bench, found: Refit) -> Scores:
    """The scores of a refit's lanes, as far as these count."""
    gradient, curvature, cost = scores(model, bench, found.point, found.free)
    weights = found.weights
    return Scores(gradient * weights[:, None], curvature * weights[:, None, None], cost * weights)


def _information(model: Model, bench: Bench, found: Refit, seen: Scores) -> np.ndarray:
    layout = Layout.of(model, bench, found.free)
    _, h = layout.summed(bench.run, seen.gradient, seen.curvature)
    h = h + layout.prior(model, found.point).curvature
    return h + np.diag(1e-12 * np.diag(h) + 1e-30)


def _clusters(bench: Bench) -> np.ndarray:
    """A number for every stretch of `CLUSTER` neighbouring lanes of one run."""
    labels: dict[tuple[int, int], int] = {}
    out = np.zeros(len(bench.run), int)
    seen: dict[int, int] = {}
    for lane, run in enumerate(bench.run.tolist()):
        place = seen[run] = seen.get(run, -1) + 1
        out[lane] = labels.setdefault((run, place // CLUSTER), len(labels))
    return out
