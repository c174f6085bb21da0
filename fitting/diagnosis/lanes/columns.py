"""Residuals of lanes with their derivatives: the columns that hypotheses are fitted and screened by."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np


@dataclasses.dataclass(frozen=True)
class Columns:
    """Residuals of lanes (times lanes, rows) in standard deviations, and displacement, velocity and friction
    force as they are, not as read, (times lanes, samples, 3).

    plain: the derivatives of residuals as a program gives them (times lanes, rows, columns + 5), with respect
    to chosen unknowns and what each lane has of its own; whitener: `Bench.whitener` of the lanes, by which
    residuals are mixed already and derivatives are when they are asked for: of a step that is refused they
    never are; used: which derivatives there are (all where it is None).
    """

    residual: np.ndarray
    plain: np.ndarray
    states: np.ndarray
    whitener: np.ndarray | None = None
    used: np.ndarray | None = None

    @functools.cached_property
    def jacobian(self) -> np.ndarray:
        """The derivatives of the residuals (times lanes, rows, columns + 5)."""
        if self.whitener is None:
            return self.plain
        used = np.arange(self.plain.shape[2]) if self.used is None else self.used
        rows, jacobian = self.whitener.shape[1], self.plain.copy()
        jacobian[:, :rows, used] = _mixed(self.whitener, self.plain[:, :rows, used])
        return jacobian

    def whitened(self, whitener: np.ndarray | None, used: np.ndarray | None = None) -> Columns:
        """Plain ones with their residuals of displacement and friction mixed as the whitener says."""
        if whitener is None:
            return self
        rows, residual = whitener.shape[1], self.residual.copy()
        residual[:, :rows] = _mixed(whitener, residual[:, :rows, None])[:, :, 0]
        return dataclasses.replace(self, residual=residual, whitener=whitener, used=used)

    def part(self, own: slice) -> Columns:
        """Those of some times."""
        return dataclasses.replace(
            self, residual=self.residual[own], plain=self.plain[own], states=self.states[own]
        )


def _mixed(whitener: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (times lanes, rows, each) mixed lane by lane; no friction is made of a displacement."""
    lanes, rows = whitener.shape[:2]
    half, each = rows // 2, values.shape[2]
    beside = values.reshape(-1, lanes, rows, each).transpose(1, 2, 0, 3)
    times = beside.shape[2]
    beside = np.ascontiguousarray(beside).reshape(lanes, rows, times * each)
    mixed = np.empty_like(beside)
    with np.errstate(over="ignore", invalid="ignore"):
        np.matmul(whitener[:, :half], beside, out=mixed[:, :half])
        np.matmul(whitener[:, half:, half:], beside[:, half:], out=mixed[:, half:])
    return mixed.reshape(lanes, rows, times, each).transpose(2, 0, 1, 3).reshape(-1, rows, each)
