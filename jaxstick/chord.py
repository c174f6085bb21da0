"""Fixed points of return maps by the chord method with Broyden's corrections, many lanes at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxstick.return_map import DISPLACEMENT, VELOCITY

Real = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]

MEMORY = 0.1
"""A component of the state on which the state one lap later depends by less than this share is no memory: it
follows from the others within the lap (an acceleration, a contact's deflection in slip), and the lap's own
value is taken for it."""

FARTHEST = 20.0
"""The longest step, in ranges of a component; the first ones near resonance lead far beyond what was seen."""

FRESH = 0.3
"""A stride of which less than this share is at right angles to the one before teaches its own direction."""

ROUNDING = 1e-6
"""By so much more than 1 a multiplier may come out that is 1."""


@dataclass(eq=False)
class Chase:
    """Lanes on their way to fixed points; arrays of shape (lanes,), (lanes, size) or (lanes, size, size).

    lane: their numbers; state; ranges, the unit of each component; jacobian of the return map in these units;
    cycles, periods of the drive that a lap lasts; residual, by how many ranges the components with memory
    still change over a lap; before, the same a lap earlier; stride, the last correction in ranges; learned,
    the direction of the last correction of the Jacobian.
    """

    lane: Index
    state: Real
    ranges: Real
    jacobian: Real
    cycles: Real
    residual: Real
    before: Real
    stride: Real
    learned: Real

    @classmethod
    def begin(cls, lane: Index, state: Real, ranges: Real, jacobian: Real, cycles: Real) -> Chase:
        """A chase from these states with these Jacobians."""
        arrays = (array.copy() for array in (state, ranges, jacobian, cycles))
        chase = cls(lane, *arrays, *(np.empty(0),) * 4)
        chase.forget()
        return chase

    def forget(self) -> None:
        """Forgets the last lap: no residual, no stride."""
        self.residual = np.full(len(self.lane), np.inf)
        self.before = self.residual.copy()
        self.stride = np.zeros_like(self.state)
        self.learned = np.zeros_like(self.state)

    def some(self, which: Index, cycles: Real) -> Chase:
        """A chase of some of the lanes, from where they are, for laps of so many periods."""
        state, ranges, jacobian = self.state[which], self.ranges[which], self.jacobian[which]
        return Chase.begin(self.lane[which], state, ranges, jacobian, cycles)

    def memory(self, threshold: float = MEMORY) -> Mask:
        """Which components a lane remembers (lanes, size); displacement and velocity always."""
        found = np.linalg.norm(self.jacobian, axis=1) > threshold
        found[:, [DISPLACEMENT, VELOCITY]] = True
        return found

    def learn(self, which: Index, change: Real, memory: Mask) -> None:
        """Takes in by how much a lap has changed the states of these lanes: residual, and Broyden's
        correction of the Jacobian for the last stride, along that part of it that leaves what the stride
        before it taught untouched, where there is much of it (Gay and Schnabel, in Nonlinear Programming 3,
        1978)."""
        gap = change / self.ranges[which]
        stride = np.where(memory, self.stride[which], 0.0)
        length = np.sum(stride**2, axis=1)
        known = self.learned[which]
        fresh = stride - known * _share(np.sum(known * stride, axis=1), np.sum(known**2, axis=1))
        much = np.sum(fresh**2, axis=1) > FRESH**2 * length
        fresh = np.where(much[:, None], fresh, stride)
        slope = fresh * _share(np.ones(len(gap)), np.sum(fresh * stride, axis=1))
        self.jacobian[which] += gap[:, :, None] * slope[:, None, :]
        self.learned[which] = fresh
        self.before[which] = self.residual[which]
        self.residual[which] = np.max(np.abs(np.where(memory, gap, 0.0)), axis=1)

    def move(self, which: Index, change: Real, memory: Mask, new_steps: bool = False) -> None:
        """The next state of these lanes: the chord's for what is memory; the rest follows by its own rows of
        the Jacobian, on the first lap of a new step length by the lap's end alone."""
        gap = change / self.ranges[which]
        step = corrected(self.jacobian[which], gap, memory)
        longest = np.max(np.abs(step), axis=1, initial=0.0)
        step *= np.minimum(1.0, FARTHEST / np.maximum(longest, 1e-300))[:, None]
        follows = gap if new_steps else gap + np.einsum("lij,lj->li", self.jacobian[which], step)
        self.stride[which] = np.where(memory, step, follows)
        self.state[which] += self.stride[which] * self.ranges[which]

    def largest(self) -> Real:
        """The largest modulus of the Jacobian's eigenvalues, lane by lane."""
        return np.max(np.abs(np.linalg.eigvals(self.jacobian)), axis=1, initial=0.0)

    def stable(self) -> Mask:
        """Which lanes have no perturbation that grows. One that stays is none: a mass that never breaks away
        keeps what its contact carried at first, with a multiplier of 1 but for rounding."""
        return self.largest() <= 1.0 + ROUNDING


def _share(part: Real, whole: Real) -> Real:
    """part/whole, 0 where there is no whole; shape (lanes, 1)."""
    return np.where(whole > 0, part / np.where(whole > 0, whole, 1.0), 0.0)[:, None]


def corrected(jacobian: Real, gap: Real, memory: Mask) -> Real:
    """(I - J)^-1 gap over the components that are memory, 0 in the others."""
    both = memory[:, :, None] & memory[:, None, :]
    system = np.eye(gap.shape[1]) - np.where(both, jacobian, 0.0)
    right = np.where(memory, gap, 0.0)
    return np.einsum("lij,lj->li", np.linalg.pinv(system, rcond=1e-12), right)
