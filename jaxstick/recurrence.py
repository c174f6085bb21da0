"""Motions that do not settle at once: marched on, and closed after as many cycles as they seem to need."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jaxstick.chord import Chase, Index, Real
from jaxstick.pursuit import TOLERANCE, Pursuit

LONGEST_PERIOD = 8
"""Periods of the drive after which a motion is still looked at for closing."""

MARCHES = (4, 8, 12, 32, 64)
"""Laps between two looks for a recurrence."""

LOOKS = 3
"""So many looks every motion is given, those that then still seem to close the rest."""

RECURRENCE = 1e-3
"""How near, in ranges, a motion must have come back to be solved for; a tenth of that, and nearer than the
time before, after more than two cycles."""


def march_on(pursuit: Pursuit, chase: Chase) -> Index:
    """Marches all lanes of the chase with fine steps until their motion closes, by itself or with help; the
    periods in drive cycles, 0 where it does not."""
    period = np.zeros(len(chase.lane), np.int64)
    alone = np.zeros(len(chase.lane), bool)
    ended = np.zeros(len(chase.lane), bool)
    trail = [chase.state.copy()]
    for look, length in enumerate(MARCHES, 1):
        for _ in range(length):
            open_ = np.flatnonzero((period == 0) & ~ended)
            if not len(open_):
                break
            trail = [*trail[-2 * LONGEST_PERIOD :], trail[-1].copy()]
            here = trail[-1][open_]
            end, chase.ranges[open_] = pursuit.lap(pursuit.course(chase.lane[open_], pursuit.fine), here)
            chase.residual[open_] = _gap(end, here, chase.ranges[open_])
            closed = chase.residual[open_] < TOLERANCE
            period[open_[closed]], alone[open_[closed]] = 1, True
            chase.state[open_] = np.where(closed[:, None], here, end)
            trail[-1][open_] = end
        open_ = np.flatnonzero((period == 0) & ~ended)
        if not len(open_):
            break
        cycles = recurrence([states[open_] for states in trail], chase.ranges[open_])
        for seeming in np.unique(cycles[cycles > 0]):
            some = open_[cycles == seeming]
            period[some] = _close(pursuit, chase, some, int(seeming))
        if look >= LOOKS:
            ended[open_[cycles == 0]] = True
    pursuit.linearise(chase, np.flatnonzero(alone), pursuit.fine)
    return period


def _close(pursuit: Pursuit, chase: Chase, which: Index, cycles: int) -> Index:
    """The chord method with new Jacobians for motions that nearly recur after so many cycles: the period
    where they close and their perturbations decay, else 0 and the chase is left as it was."""
    some = chase.some(which)
    everyone = np.arange(len(which))
    pursuit.linearise(some, everyone, pursuit.fine, cycles)
    period = np.where(pursuit.refine(some, cycles), cycles, 0)
    for shorter in (divisor for divisor in range(1, cycles) if cycles % divisor == 0):
        same = np.flatnonzero(period == cycles)
        if len(same):
            course = pursuit.course(some.lane[same], pursuit.fine, shorter)
            end, _ = pursuit.lap(course, some.state[same])
            period[same[_gap(end, some.state[same], some.ranges[same]) < 100 * TOLERANCE]] = shorter
    closed = np.flatnonzero(period)
    pursuit.linearise(some, closed, pursuit.fine, period[closed].astype(float))
    period[some.largest() > 1.0] = 0
    found = np.flatnonzero(period)
    chase.state[which[found]], chase.jacobian[which[found]] = some.state[found], some.jacobian[found]
    chase.residual[which[found]] = some.residual[found]
    return period


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
    return np.where(np.where(shortest < 2, found < RECURRENCE, shrinks), shortest + 1, 0)


def _gap(one: Real, other: Real, ranges: Real) -> Real:
    return np.max(np.abs(one - other) / ranges, axis=1, initial=0.0)
