"""The normal equations of every lane, and what each lane can make of residuals by itself."""

from __future__ import annotations

import numpy as np

from fitting.diagnosis.lanes.columns import Columns
from fitting.diagnosis.lanes.wander import OWN


def normal(columns: Columns) -> tuple[np.ndarray, np.ndarray]:
    """J'r and J'J of every lane, what it has of its own last; no pull at all of a lane where they are no
    numbers."""
    jacobian = columns.jacobian
    with np.errstate(over="ignore", invalid="ignore"):
        gradient = np.einsum("lrc,lr->lc", jacobian, columns.residual)
        curvature = jacobian.transpose(0, 2, 1) @ jacobian
    broken = ~(np.isfinite(gradient).all(1) & np.isfinite(curvature).all((1, 2)))
    gradient[broken], curvature[broken] = 0.0, np.eye(gradient.shape[1])
    return gradient, curvature


def fall(gradient: np.ndarray, curvature: np.ndarray, change: np.ndarray) -> np.ndarray:
    """By how much the linearised cost of every lane falls for a change (lanes, each) of its unknowns, given
    J'r and J'J by them."""
    slope = np.einsum("lc,lc->l", change, gradient)
    return -2 * slope - np.einsum("lc,lcd,ld->l", change, curvature, change)


class Projection:
    """Takes out of values (lanes, rows, ..) what each lane can make of them by itself."""

    def __init__(self, columns: Columns) -> None:
        self._basis, self._root = np.linalg.qr(columns.jacobian[:, :, -OWN:])

    def __call__(self, values: np.ndarray) -> np.ndarray:
        return values - self._basis @ (self._basis.transpose(0, 2, 1) @ values)

    def answer(self, values: np.ndarray) -> np.ndarray:
        """By how much what each lane has of its own (lanes, own, ..) is to move where residuals change by
        these values, for the least cost."""
        root = self._root + 1e-30 * np.eye(OWN)
        return -np.linalg.solve(root, self._basis.transpose(0, 2, 1) @ values)
