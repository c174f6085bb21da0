"""How sure the constants are: intervals that stay right when residuals are coloured."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from scipy.stats import f as variance_ratio
from scipy.stats import t as student

from fitting.newton import Solution
from fitting.stage import Stage

LEVEL = 0.95
FEWEST_RUNS, SURELY = 3, 0.01
"""From so many runs on they are compared; and the probability below which what they show is no chance."""


@dataclasses.dataclass(frozen=True)
class Spread:
    """Covariance of the coordinates (p, p), their Student degrees of freedom (p), and the covariance that
    white residuals would give (p, p); `by_runs`: whether runs are the clusters, for they surely disagree."""

    covariance: np.ndarray
    dof: np.ndarray
    model: np.ndarray
    by_runs: bool = False

    def widened(self, covariance: np.ndarray) -> Spread:
        """The spread with the covariance of another, independent source of error added."""
        return dataclasses.replace(self, covariance=self.covariance + covariance)

    def deviation(self) -> np.ndarray:
        return np.sqrt(np.diag(self.covariance))

    def quantile(self, level: float = LEVEL) -> np.ndarray:
        """Two-sided Student quantile of every coordinate."""
        return student.ppf(0.5 + level / 2, self.dof)

    def inflation(self) -> np.ndarray:
        """Robust over model-based variance of every coordinate (1 where residuals are white)."""
        model = np.diag(self.model)
        return np.where(model > 0, np.diag(self.covariance) / np.where(model > 0, model, 1.0), 1.0)


class Robust(NamedTuple):
    """A cluster-robust covariance of the coordinates (p, p), and its degrees of freedom (p)."""

    covariance: np.ndarray
    dof: np.ndarray

    def is_surely_less_than(self, other: Robust) -> bool:
        """Whether the other variance of a coordinate is larger by more than chance (F-test)."""
        ratio = np.diag(other.covariance) / np.maximum(np.diag(self.covariance), 1e-300)
        return bool((variance_ratio.sf(ratio, other.dof, self.dof) < SURELY / len(ratio)).any())


def spread(stage: Stage, solution: Solution) -> Spread:
    """Cluster-robust covariance of the coordinates, of those on a bound too: the truth need not lie there.

    Clusters are stretches of runs; whole runs where these surely disagree on some coordinate, as where
    friction is not the same in all of them. A few clusters can by chance agree too well: no variance is taken
    below that of white residuals.
    """
    scores, curvatures = stage.misfit.scores(stage.lanes, solution.coordinates, solution.starts, stage.blocks)
    weights = np.repeat(solution.weights, stage.blocks)
    score, curvature = scores * weights[:, None], curvatures * weights[:, None, None]
    prior = stage.misfit.unknowns.prior(solution.coordinates)[2]
    root = np.linalg.cholesky(_regular(curvature.sum(0) + np.diag(prior)))
    inverse_root = np.linalg.inv(root)
    found = _robust(score, curvature, stage.clusters.reshape(-1), inverse_root)
    runs = np.repeat([segment.run for segment in stage.segments], stage.blocks)
    disagree = False
    if len(np.unique(runs)) >= FEWEST_RUNS:
        by_run = _robust(score, curvature, runs, inverse_root)
        disagree = found.is_surely_less_than(by_run)
        found = by_run if disagree else found
    covariance = found.covariance
    model = inverse_root.T @ inverse_root
    model = model * max(1.0, float(np.median(solution.linear.cost / stage.lanes.counted())))
    short = np.sqrt(np.maximum(1.0, np.diag(model) / np.maximum(np.diag(covariance), 1e-300)))
    return Spread(covariance * np.outer(short, short), found.dof, model, disagree)


def _robust(
    score: np.ndarray, curvature: np.ndarray, cluster: np.ndarray, inverse_root: np.ndarray
) -> Robust:
    """V = H^-1 (sum_c g_c g_c') H^-1 with the scores g_c summed over the blocks of cluster c, each corrected
    for its own leverage as (I - H_c H^-1)^(-1/2) (the CR2 estimator; Bell, McCaffrey, Survey Methodology 28
    (2002) 169); degrees of freedom by Satterthwaite, from how unevenly the clusters carry each coordinate."""
    groups, member = np.unique(cluster, return_inverse=True)
    score = _summed(score, member, len(groups))
    curvature = _summed(curvature, member, len(groups))
    leverage = inverse_root @ curvature @ inverse_root.T
    value, vector = np.linalg.eigh(0.5 * (leverage + leverage.transpose(0, 2, 1)))
    correction = vector * np.clip(1 - value, 0.05, 1.0)[:, None, :] ** -0.5 @ vector.transpose(0, 2, 1)
    corrected = np.einsum("cij,cj->ci", correction, score @ inverse_root.T)
    covariance = inverse_root.T @ (corrected.T @ corrected) @ inverse_root
    inverse = inverse_root.T @ inverse_root
    carried = np.einsum("ij,cjk,ki->ci", inverse, curvature, inverse)
    power = np.sum(carried**2, axis=0)
    return Robust(covariance, np.where(power > 0, carried.sum(0) ** 2 / np.where(power > 0, power, 1.0), 1.0))


def _summed(values: np.ndarray, member: np.ndarray, groups: int) -> np.ndarray:
    out = np.zeros((groups, *values.shape[1:]))
    np.add.at(out, member, values)
    return out


def _regular(matrix: np.ndarray) -> np.ndarray:
    """The matrix with directions that the data do not see held by a vanishing ridge."""
    return matrix + np.diag(1e-12 * np.diag(matrix) + 1e-30)
