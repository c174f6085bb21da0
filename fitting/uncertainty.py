"""How sure the constants are: intervals that stay right when residuals are coloured."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.stats import t as student

from fitting.newton import Solution
from fitting.stage import Stage

LEVEL = 0.95


@dataclasses.dataclass(frozen=True)
class Spread:
    """Covariance of the coordinates (p, p), their Student degrees of freedom (p), and the covariance that
    white residuals would give (p, p)."""

    covariance: np.ndarray
    dof: np.ndarray
    model: np.ndarray

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


def spread(stage: Stage, solution: Solution) -> Spread:
    """Cluster-robust covariance of the coordinates, of those on a bound too: the truth need not lie there.

    V = H^-1 (sum_c g_c g_c') H^-1 with the scores g_c summed over the blocks of cluster c, each corrected for
    its own leverage as (I - H_c H^-1)^(-1/2) (the CR2 estimator; Bell, McCaffrey, Survey Methodology 28
    (2002) 169); degrees of freedom by Satterthwaite, from how unevenly the clusters carry each coordinate.
    A few clusters can by chance agree too well: no variance is taken below that of white residuals.
    """
    scores, curvatures = stage.misfit.scores(stage.lanes, solution.coordinates, solution.starts, stage.blocks)
    groups, member = np.unique(stage.clusters.reshape(-1), return_inverse=True)
    weights = np.repeat(solution.weights, stage.blocks)
    score = _summed(scores * weights[:, None], member, len(groups))
    curvature = _summed(curvatures * weights[:, None, None], member, len(groups))
    prior = stage.misfit.unknowns.prior(solution.coordinates)[2]
    root = np.linalg.cholesky(_regular(curvature.sum(0) + np.diag(prior)))
    inverse_root = np.linalg.inv(root)
    leverage = inverse_root @ curvature @ inverse_root.T
    value, vector = np.linalg.eigh(0.5 * (leverage + leverage.transpose(0, 2, 1)))
    correction = vector * np.clip(1 - value, 0.05, 1.0)[:, None, :] ** -0.5 @ vector.transpose(0, 2, 1)
    corrected = np.einsum("cij,cj->ci", correction, score @ inverse_root.T)
    covariance = inverse_root.T @ (corrected.T @ corrected) @ inverse_root
    model = inverse_root.T @ inverse_root
    model = model * max(1.0, float(np.median(solution.linear.cost / stage.lanes.counted())))
    short = np.sqrt(np.maximum(1.0, np.diag(model) / np.maximum(np.diag(covariance), 1e-300)))
    covariance = covariance * np.outer(short, short)
    carried = np.einsum("ij,cjk,ki->ci", model, curvature, model)
    power = np.sum(carried**2, axis=0)
    dof = np.where(power > 0, carried.sum(0) ** 2 / np.where(power > 0, power, 1.0), 1.0)
    return Spread(covariance, dof, model)


def _summed(values: np.ndarray, member: np.ndarray, groups: int) -> np.ndarray:
    out = np.zeros((groups, *values.shape[1:]))
    np.add.at(out, member, values)
    return out


def _regular(matrix: np.ndarray) -> np.ndarray:
    """The matrix with directions that the data do not see held by a vanishing ridge."""
    return matrix + np.diag(1e-12 * np.diag(matrix) + 1e-30)
