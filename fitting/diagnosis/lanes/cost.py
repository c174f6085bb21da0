"""What lanes cost, and what all of them leave as a misfit."""

from __future__ import annotations

import math

import numpy as np

from fitting.diagnosis.lanes.columns import Columns
from fitting.diagnosis.lanes.wander import OWN, START
from fitting.newton import Robust

BROKEN = 1e30
"""What a lane costs whose motion is no number, as with parameters that no rig has."""


def misfit_of(cost: np.ndarray, dof: np.ndarray) -> float:
    """Chi-square per degree of freedom; of lanes far above the typical one, what Huber leaves of them."""
    return Robust.around(cost, dof).total(cost) / float(dof.sum())


def whole_cost(columns: Columns) -> np.ndarray:
    """The cost of every lane with the prior of its start."""
    return _finite(np.einsum("lr,lr->l", columns.residual, columns.residual))


def data_cost(columns: Columns) -> np.ndarray:
    """The cost of every lane without the prior of its start."""
    with np.errstate(over="ignore"):
        squares = columns.residual**2
    return _finite(squares[:, :-OWN].sum(1) + squares[:, START - OWN :].sum(1))


def significance(excess: np.ndarray) -> float:
    """By how many standard deviations a sum over lanes stands above zero, by how they scatter around their
    mean: what one lane has alone comes to one."""
    spread = float(np.std(excess)) * math.sqrt(len(excess))
    return float(np.sum(excess)) / max(spread, 1e-300)


def _finite(cost: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(cost), cost, BROKEN)
