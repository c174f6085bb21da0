"""How sure the parameters of a refit are: intervals that stay right when residuals are coloured."""

from __future__ import annotations

import numpy as np
from scipy.stats import t as student

from fitting.diagnosis.bench import Bench, Point
from fitting.diagnosis.layout import Layout
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import Projection, Refit, chosen_columns, job

CLUSTER = 3
"""So many neighbouring lanes of a run share their errors."""
LEVEL = 0.95


def deviations(model: Model, bench: Bench, found: Refit) -> tuple[np.ndarray, float]:
    """Standard deviations of the free coordinates of a refit, and the Student quantile that goes with them.

    The covariance is H^-1 (sum over clusters of g_c g_c') H^-1 with the scores g_c of neighbouring lanes
    summed, times C/(C - 1) for C clusters; never below that of white residuals of the size that is left.
    """
    free = found.free
    gradient, curvature = _scores(model, bench, found.point, free)
    gradient, curvature = gradient * found.weights[:, None], curvature * found.weights[:, None, None]
    layout = Layout.of(model, bench, free)
    _, h = layout.summed(bench.run, gradient, curvature)
    h = h + layout.prior(model, found.point).curvature
    h = h + np.diag(1e-12 * np.diag(h) + 1e-30)
    inverse = np.linalg.inv(h)
    cluster = _clusters(bench)
    total = np.zeros_like(h)
    for number in range(cluster.max() + 1):
        mine = np.flatnonzero(cluster == number)
        score, _ = layout.summed(bench.run[mine], gradient[mine], curvature[mine])
        total += np.outer(score, score)
    count = cluster.max() + 1
    robust = np.diag(inverse @ total @ inverse)[layout.of_free] * count / max(count - 1, 1)
    white = np.diag(inverse)[layout.of_free] * max(found.misfit, 1.0)
    quantile = float(student.ppf(0.5 + LEVEL / 2, max(count - len(free), 2)))
    return np.sqrt(np.maximum(robust, white)), quantile


def _scores(model: Model, bench: Bench, point: Point, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """J'r and J'J of level and free unknowns of every lane, its start eliminated."""
    (columns,) = model.columns(
        [job(model, bench, point, chosen_columns(free, model.level, len(bench.lanes)))]
    )
    own = Projection(columns)(columns.jacobian[:, :, : 1 + len(free)])
    gradient = np.einsum("lrc,lr->lc", own, columns.residual)
    return gradient, own.transpose(0, 2, 1) @ own


def _clusters(bench: Bench) -> np.ndarray:
    """A number for every stretch of `CLUSTER` neighbouring lanes of one run."""
    labels: dict[tuple[int, int], int] = {}
    out = np.zeros(len(bench.run), int)
    seen: dict[int, int] = {}
    for lane, run in enumerate(bench.run.tolist()):
        place = seen[run] = seen.get(run, -1) + 1
        out[lane] = labels.setdefault((run, place // CLUSTER), len(labels))
    return out
