"""Joins short segments into long ones: multiple shooting whose gaps are closed step by step.

A long simulation that begins a little wrong misses an event sooner or later, and least squares over its start
then sees a cost full of false minima. Short segments, each with a start of its own, never leave the record.
They become one long simulation when every segment ends where the next one begins, so these gaps are closed
by a penalty that grows. Source of the idea: Bock, Recent advances in parameter identification techniques for
ordinary differential equations, in: Numerical Treatment of Inverse Problems, Birkhauser 1983.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from fitting.lanes import Followed, Lanes, Misfit
from fitting.newton import Robust, bounded_step
from fitting.segments import START_FREEDOM, Segment

LOOSENESS = (1.0, 0.03, 1e-3, 1e-5)
"""Standard deviations of the gaps, one after the other, in units of what the noise alone makes of a start."""
ITERATIONS = 8
ENOUGH = 1e-3
FORCE_SHARE = 0.1
STUCK = 1e6

Chain = tuple[int, ...]
"""Lanes in their order in time, each going on where the one before ends."""


@dataclasses.dataclass(frozen=True)
class Joined:
    """Coordinates (p) and starts (lanes, 3) with the gaps closed, and the cost of every lane."""

    coordinates: np.ndarray
    starts: np.ndarray
    cost: np.ndarray


def chains(parts: Sequence[Segment], wholes: Sequence[Segment]) -> list[Chain]:
    """For every long segment the short ones that it is made of."""
    return [
        tuple(
            number
            for number, part in enumerate(parts)
            if part.run == whole.run and whole.first <= part.first < whole.last
        )
        for whole in wholes
    ]


def join(
    misfit: Misfit,
    lanes: Lanes,
    links: Sequence[Chain],
    coordinates: np.ndarray,
    starts: np.ndarray,
    *,
    progress: Callable[[float], None] = lambda cost: None,
) -> Joined:
    """Closes the gaps between the lanes of every chain, all unknowns and starts free; every lane is in one.

    `lanes` are laid out one sample beyond their segments.
    """
    search = _Search(misfit, lanes, list(links), coordinates, starts)
    for looseness in LOOSENESS:
        search.settle(looseness, progress)
    return Joined(search.coordinates, search.starts, search.followed.linear.cost)


class _Search:
    """A Levenberg-Marquardt search over unknowns and starts, the gaps weighed by a looseness."""

    def __init__(
        self, misfit: Misfit, lanes: Lanes, links: list[Chain], coordinates: np.ndarray, starts: np.ndarray
    ) -> None:
        self.misfit, self.lanes, self.links = misfit, lanes, links
        self.coordinates, self.starts = coordinates, starts
        deviation = np.asarray(lanes.start_deviation)
        self.unit = deviation / np.array([START_FREEDOM, START_FREEDOM, 1 / FORCE_SHARE])
        self.followed = self._follow(coordinates, starts)

    def settle(self, looseness: float, progress: Callable[[float], None]) -> None:
        """Minimises the cost with the gaps in units of `looseness` times their own scale."""
        loss = Robust.around(self.followed.linear.cost, self.lanes.counted())
        weights = loss.weights(self.followed.linear.cost)
        damping, cost = 1e-4, self._cost(self.coordinates, self.starts, self.followed, weights, looseness)
        for _ in range(ITERATIONS):
            trial, trial_starts = self._step(weights, looseness, damping)
            followed = self._follow(trial, trial_starts)
            found = self._cost(trial, trial_starts, followed, weights, looseness)
            if not found < cost:
                damping *= 30
                if damping > STUCK:
                    break
                continue
            gain, cost = cost - found, found
            self.coordinates, self.starts, self.followed = trial, trial_starts, followed
            damping = max(0.1 * damping, 1e-9)
            progress(cost)
            if gain < ENOUGH * cost:
                break

    def _follow(self, coordinates: np.ndarray, starts: np.ndarray) -> Followed:
        each = np.broadcast_to(coordinates, (len(self.lanes), len(coordinates)))
        return self.misfit.follow(self.lanes, each, starts)

    def _cost(
        self,
        coordinates: np.ndarray,
        starts: np.ndarray,
        followed: Followed,
        weights: np.ndarray,
        looseness: float,
    ) -> float:
        before, after = self._links()
        gap = (followed.end[before] - starts[after]) / (looseness * self.unit[after])
        cost = weights @ followed.linear.cost + np.sum(gap**2) + self.misfit.unknowns.prior(coordinates)[0]
        return float(cost)

    def _links(self) -> tuple[np.ndarray, np.ndarray]:
        """The lanes before and after every gap."""
        before = [lane for chain in self.links for lane in chain[:-1]]
        after = [lane for chain in self.links for lane in chain[1:]]
        return np.array(before, int), np.array(after, int)

    def _step(self, weights: np.ndarray, looseness: float, damping: float) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and starts after one damped step; the starts are eliminated chain by chain."""
        unknowns = self.misfit.unknowns
        p = len(unknowns)
        _, gradient, prior_curvature = unknowns.prior(self.coordinates)
        curvature = np.diag(prior_curvature)
        eliminated = []
        for chain in self.links:
            lanes = np.array(chain)
            own_gradient, own, coupling, g, h = self._normal(lanes, weights, looseness, p)
            own[np.diag_indices_from(own)] *= 1 + damping
            solved = np.linalg.solve(own, np.column_stack([own_gradient, coupling]))
            gradient = gradient + g - coupling.T @ solved[:, 0]
            curvature = curvature + h - coupling.T @ solved[:, 1:]
            eliminated.append((lanes, solved))
        step, _ = bounded_step(
            self.coordinates,
            gradient,
            curvature,
            damping,
            np.zeros(p, bool),
            unknowns.lower,
            unknowns.upper,
        )
        trial = np.clip(self.coordinates + step, unknowns.lower, unknowns.upper)
        starts = self.starts.copy()
        for lanes, solved in eliminated:
            starts[lanes] -= (solved[:, 0] + solved[:, 1:] @ step).reshape(-1, 3)
        return trial, starts

    def _normal(self, lanes: np.ndarray, weights: np.ndarray, looseness: float, p: int) -> tuple:
        """Gradient and curvature of one chain: in its starts, of starts with unknowns, in the unknowns."""
        linear, n = self.followed.linear, len(lanes)
        weight = weights[lanes]
        lane_gradient = weight[:, None] * linear.gradient[lanes]
        lane_curvature = weight[:, None, None] * linear.curvature[lanes]
        gradient, curvature = np.zeros((n, 3)), np.zeros((n, 3, n, 3))
        coupling = np.array(lane_curvature[:, p:, :p])
        gradient += lane_gradient[:, p:]
        here = np.arange(n)
        curvature[here, :, here, :] += lane_curvature[:, p:, p:]
        g, h = lane_gradient[:, :p].sum(0), lane_curvature[:, :p, :p].sum(0)
        if n > 1:
            before, after = lanes[:-1], lanes[1:]
            unit = looseness * self.unit[after]
            gap = (self.followed.end[before] - self.starts[after]) / unit
            slope = self.followed.end_jacobian[before] / unit[:, :, None]
            of_unknowns, of_start = slope[:, :, :p], slope[:, :, p:]
            gradient[:-1] += np.einsum("kis,ki->ks", of_start, gap)
            gradient[1:] -= gap / unit
            coupling[:-1] += np.einsum("kis,kip->ksp", of_start, of_unknowns)
            coupling[1:] -= of_unknowns / unit[:, :, None]
            one, other = here[:-1], here[1:]
            curvature[one, :, one, :] += np.einsum("kis,kit->kst", of_start, of_start)
            curvature[other, :, other, :] += np.einsum("ki,ij->kij", unit**-2, np.eye(3))
            across = of_start / unit[:, :, None]
            curvature[other, :, one, :] -= across
            curvature[one, :, other, :] -= across.transpose(0, 2, 1)
            g = g + np.einsum("kip,ki->p", of_unknowns, gap)
            h = h + np.einsum("kip,kiq->pq", of_unknowns, of_unknowns)
        return gradient.reshape(-1), curvature.reshape(3 * n, 3 * n), coupling.reshape(3 * n, p), g, h
