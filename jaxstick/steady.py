"""Periodic states of sine-driven oscillators, found directly instead of marched to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxstick.chord import Index, Real
from jaxstick.laps import Course, Laps
from jaxstick.pursuit import Pursuit
from jaxstick.recurrence import LONGEST_PERIOD, march_on

RESOLUTION = 200.0
"""Steps on a period of the contact's ring (error about 5e-6 of the stroke at 200)."""


@dataclass(frozen=True, eq=False)
class PeriodicStates:
    """Where each lane's motion closes on itself; arrays of shape (lanes,) or (lanes, size).

    course: section, steps and cycles of the lap that closes, as many cycles as the motion's period; state at
    its beginning; period in drive cycles, 0 where the motion is not periodic (state and course are then the
    beginning of some `LONGEST_PERIOD` cycles of it); residual: by how many of their ranges the components of
    the state that the motion depends on change over the lap, over one cycle where it is not periodic;
    multipliers (lanes, size): eigenvalues of the lap's Jacobian, largest first, to about 0.05, nan where the
    motion is not periodic; laps: the work, in periods of the drive with all steps.
    """

    course: Course
    state: Real
    period: Index
    residual: Real
    multipliers: NDArray[np.complex128]
    laps: Real


def periodic_states(laps: Laps, resolution: float = RESOLUTION) -> PeriodicStates:
    """The periodic state of every lane that a motion from rest leads to.

    A few coarse cycles from rest lead near; the section is laid where the mass is fastest, since there it
    slips and the contact's deflection is no memory. A Jacobian by differences and the chord method with
    Broyden's corrections find the periodic state of the coarse steps, and from there that of the fine ones.
    What does not get there so is marched on, looked at for a recurrence after 1 to 8 cycles, and solved for
    that. A state whose perturbations grow (a multiplier beyond 1) is not taken, since no
    motion stays there. Every lane is treated on its own, whoever else is there.
    """
    pursuit = Pursuit(laps, resolution)
    chase = pursuit.from_rest()
    marched = chase.state.copy()
    near = pursuit.approach(chase)
    solved = near & pursuit.refine(chase, np.flatnonzero(near))
    pursuit.settle(chase, np.flatnonzero(solved))
    solved &= chase.stable()
    period = solved.astype(np.int64)
    hard = np.flatnonzero(~solved)
    if len(hard):
        chase.state[hard] = marched[hard]
        some = chase.some(hard, chase.cycles[hard])
        period[hard] = march_on(pursuit, some)
        chase.state[hard], chase.jacobian[hard] = some.state, some.jacobian
        chase.residual[hard] = some.residual
    cycles = np.where(period > 0, period, LONGEST_PERIOD)
    return PeriodicStates(
        pursuit.course(chase.lane, pursuit.fine, cycles.astype(float)),
        chase.state,
        period,
        chase.residual,
        ordered_multipliers(chase.jacobian, period),
        pursuit.work,
    )


def ordered_multipliers(jacobians: Real, period: Index) -> NDArray[np.complex128]:
    """Eigenvalues of these Jacobians (lanes, size, size), largest first; nan for a period of 0."""
    found = np.linalg.eigvals(jacobians).astype(np.complex128)
    order = np.argsort(-np.abs(found), axis=1, kind="stable")
    found = np.take_along_axis(found, order, 1)
    found[period == 0] = np.nan
    return found
