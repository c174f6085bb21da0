"""Motions that do not settle at once: marched on, and closed after as many cycles as they seem to need."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jaxstick.chord import Chase, Index, Real
from jaxstick.pursuit import TOLERANCE, Pursuit

LONGEST_PERIOD = 8
"""Periods of the drive after which a motion is still looked at for closing."""

MARCHES = (12, 12, 24)
"""Laps between two looks for a recurrence."""

LOOKS = 2
"""So many looks every motion is given, those that then still seem to close the rest."""

TRIES = 4
"""Cycles that a motion is solved for, all its tries together."""

RECURRENCE = 1e-3
"""How near, in ranges, a motion must have come back to be solved for; a tenth of that, and nearer than the
time before, after more than one cycle."""


def march_on(pursuit: Pursuit, chase: Chase) -> Index:
    """Marches all lanes of the chase with medium steps until their motion seems to recur and can be solved
    for with fine ones; the periods in drive cycles, 0 where there is none."""
    period = np.zeros(len(chase.lane), np.int64)
    tried = np.zeros(len(chase.lane))
    open_ = np.arange(len(chase.lane))
    trail = [chase.state.copy()]
    for look, length in enumerate(MARCHES, 1):
        course = pursuit.course(chase.lane[open_], pursuit.medium, np.ones(len(open_)))
        for _ in range(length):
            here = trail[-1][open_]
            trail = [*trail[-2 * LONGEST_PERIOD :], trail[-1].copy()]
            trail[-1][open_], chase.ranges[open_] = pursuit.lap(course, here)
        chase.state[open_] = trail[-1][open_]
        chase.residual[open_] = _gap(trail[-1][open_], trail[-2][open_], chase.ranges[open_])
        cycles = recurrence([states[open_] for states in trail], chase.ranges[open_])
        cycles[tried[open_] + cycles > TRIES] = 0
        seeming = open_[cycles > 0]
        if len(seeming):
            period[seeming] = _close(pursuit, chase, seeming, cycles[cycles > 0])
            tried[open_] += cycles
        open_ = open_[(period[open_] == 0) & ((look < LOOKS) | (cycles > 0))]
        if not len(open_):
            break
    return period


def _close(pursuit: Pursuit, chase: Chase, which: Index, cycles: Index) -> Index:
    """The chord method with new Jacobians for motions that nearly recur after so many cycles: the period
    where they close and their perturbations decay, else 0 and the chase is left as it was."""
    some = chase.some(which, cycles.astype(float))
    everyone = np.arange(len(which))
    ends = pursuit.linearise(some, everyone, pursuit.fine)
    closed = np.flatnonzero(pursuit.refine(some, everyone, ends))
    shortest = _shortest(pursuit, some, closed)
    if len(shortest):
        pursuit.linearise(some, shortest, pursuit.fine)
    pursuit.settle(some, np.setdiff1d(closed, shortest))
    found = closed[some.stable()[closed]]
    chase.state[which[found]], chase.jacobian[which[found]] = some.state[found], some.jacobian[found]
    chase.residual[which[found]] = some.residual[found]
    period = np.zeros(len(which), np.int64)
    period[found] = some.cycles[found]
    return period


def _shortest(pursuit: Pursuit, chase: Chase, closed: Index) -> Index:
    """Sets the cycles of motions that close to the least number after which they do, a divisor of those they
    are solved for; which were shortened."""
    solved = chase.cycles.copy()
    for shorter in range(1, LONGEST_PERIOD // 2 + 1):
        whole = (solved % shorter == 0) & (solved > shorter) & (chase.cycles == solved)
        some = closed[whole[closed]]
        if len(some):
            course = pursuit.course(chase.lane[some], pursuit.fine, np.full(len(some), float(shorter)))
            end, _ = pursuit.lap(course, chase.state[some])
            same = _gap(end, chase.state[some], chase.ranges[some]) < 100 * TOLERANCE
            chase.cycles[some[same]] = shorter
    return np.flatnonzero(chase.cycles < solved)


def recurrence(trail: Sequence[Real], ranges: Real) -> Index:
    """After how many cycles each lane's motion seems to recur; 0 where it does not. `trail` are the states
    (lanes, size) after successive laps, three at least; `ranges` (lanes, size) their components' units."""
    last = len(trail) - 1

    def distance(later: int, cycles: int) -> Real:
        return _gap(trail[later], trail[later - cycles], ranges)

    lengths = range(1, last // 2 + 1)
    now = np.stack([distance(last, length) for length in lengths])
    earlier = np.stack([distance(last - length, length) for length in lengths])
    shortest = np.argmax(now <= 5 * np.min(now, axis=0), axis=0)
    found, before = (np.take_along_axis(gaps, shortest[None], 0)[0] for gaps in (now, earlier))
    shrinks = (found < 0.9 * before) & (found < RECURRENCE / 10)
    return np.where(np.where(shortest < 1, found < RECURRENCE, shrinks), shortest + 1, 0)


def _gap(one: Real, other: Real, ranges: Real) -> Real:
    return np.max(np.abs(one - other) / ranges, axis=1, initial=0.0)
