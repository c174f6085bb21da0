"""Return maps of many lanes as a search for their fixed points uses them: coarse, fine, and their cost."""

from __future__ import annotations

import numpy as np

from jaxstick.chord import MEMORY, Chase, Index, Mask, Real
from jaxstick.laps import Course, Laps
from jaxstick.return_map import ACCELERATION

COARSE = 20.0
"""Steps on a period of the contact's ring where a state is only sought: an error of 5e-4 of the stroke, for a
tenth of the work."""

MEDIUM = 80.0
"""The same where a motion is marched on: an error of 3e-5, for two fifths of the work."""

TOLERANCE = 1e-9
"""How far a lap may be from closing, in ranges of each component over the lap."""

COARSE_TOLERANCE = 1e-5
"""The same with coarse steps, whose own error is larger."""

FIRST_LAPS = 6
"""Coarse laps from rest before a fixed point is sought."""

COARSE_PASSES, FINE_PASSES = 8, 10
"""Laps after which the chord method is given up."""

POOR = 0.3
"""With coarse steps: a lap that leaves more than this share of the residual asks for a new Jacobian."""

FAILED, FAILURES, NEARLY = 0.7, 3, 1e-7
"""With fine steps: a lap that leaves more than this share of the residual is a failure, unless the residual
is below the last figure; so many of them are too many."""

DOUBTFUL = 0.8
"""A multiplier beyond this, as a search leaves it, is computed anew before a state is called stable."""

NEW_STEPS_MEMORY = 0.3
"""The threshold of memory on the first lap with fine steps: what depends on the length of the step, such as
the excess of a trial force, still has its coarse value then and must not act as memory."""

DIFFERENCE = 1e-6
"""By how many ranges a component is moved for a column of the Jacobian."""

FORGOTTEN = 0.01
"""A component whose column was smaller than this, in ranges, is left out of further Jacobians."""


class Pursuit:
    """The return maps of some lanes, with their sections, their steps a period, coarse, medium and fine, and
    the work done so far in periods with fine steps."""

    def __init__(self, laps: Laps, resolution: float):
        self.laps = laps
        self.fine = laps.steps(resolution)
        self.coarse = np.minimum(laps.steps(COARSE), self.fine)
        self.medium = np.minimum(laps.steps(MEDIUM), self.fine)
        self.section = np.zeros(len(laps))
        self.work = np.zeros(len(laps))

    def course(self, lanes: Index, steps: Real, cycles: Real) -> Course:
        """Laps of these lanes from their sections."""
        return Course(lanes, self.section[lanes], steps[lanes], cycles)

    def _course(self, chase: Chase, which: Index, steps: Real) -> Course:
        return self.course(chase.lane[which], steps, chase.cycles[which])

    def lap(self, course: Course, state: Real) -> tuple[Real, Real]:
        """The ends of these laps and the ranges of the components on the way."""
        way = self.laps.traverse(course, state)
        self._count(course)
        return way.end, _ranges(way.least, way.greatest)

    def _count(self, course: Course) -> None:
        np.add.at(self.work, course.lane, course.steps * course.cycles / self.fine[course.lane])

    def from_rest(self) -> Chase:
        """All lanes after coarse cycles from rest, their sections laid where they were fastest at last."""
        lanes, once = np.arange(len(self.laps)), np.ones(len(self.laps))
        course = self.course(lanes, self.coarse, once)
        state = self.laps.begin(course)
        for _ in range(FIRST_LAPS - 1):
            state = self.lap(course, state)[0]
        way = self.laps.traverse(course, state)
        self._count(course)
        self.section = np.mod(way.fastest_at, 1.0)
        size = state.shape[1]
        ranges = _ranges(way.least, way.greatest)
        return Chase.begin(lanes, way.fastest, ranges, np.zeros((len(lanes), size, size)), once)

    def linearise(self, chase: Chase, which: Index, steps: Real) -> Real:
        """New Jacobians of these lanes at their present states; the ends of their laps."""
        return self._differentiate(chase, which, self._course(chase, which, steps))

    def _differentiate(self, chase: Chase, which: Index, course: Course, end: Real | None = None) -> Real:
        """The Jacobians by differences; the laps' ends. The acceleration follows from the rest of the state
        as the step goes to zero, and is left out."""
        ranges = chase.ranges[which]
        first = np.max(np.abs(chase.jacobian[which]), axis=(1, 2), initial=0.0) == 0
        wanted = chase.memory(FORGOTTEN)[which] | first[:, None]
        wanted[:, ACCELERATION] = False
        if end is None:
            self._count(course)
        self._count(course.take(np.nonzero(wanted)[0]))
        end, slopes = self.laps.jacobian(course, chase.state[which], DIFFERENCE * ranges, wanted, end)
        found = slopes * ranges[:, None, :] / ranges[:, :, None]
        chase.jacobian[which] = np.where(np.isfinite(found), found, 0.0)
        chase.learned[which] = 0.0
        return end

    def settle(self, chase: Chase, which: Index) -> None:
        """New Jacobians of those of these lanes of which the search leaves it in doubt whether perturbations
        of them decay."""
        doubtful = which[chase.largest()[which] > DOUBTFUL]
        if len(doubtful):
            self.linearise(chase, doubtful, self.fine)

    def approach(self, chase: Chase) -> Mask:
        """The chord method with coarse steps; which lanes end within the coarse tolerance."""
        active = np.arange(len(chase.lane))
        end = self.linearise(chase, active, self.coarse)
        for number in range(COARSE_PASSES):
            course = self._course(chase, active, self.coarse)
            if number > 0:
                end, _ = self.lap(course, chase.state[active])
            change = _finite(end - chase.state[active])
            chase.learn(active, change, chase.memory()[active])
            going = chase.residual[active] >= COARSE_TOLERANCE
            poor = going & (chase.residual[active] > POOR * chase.before[active])
            if poor.any():
                self._differentiate(chase, active[poor], course.take(poor), end[poor])
            active, change = active[going], change[going]
            if not len(active):
                break
            chase.move(active, change, chase.memory()[active])
        return chase.residual < COARSE_TOLERANCE

    def refine(self, chase: Chase, which: Index, known: Real | None = None) -> Mask:
        """The chord method with fine steps on these lanes; which lanes end within the tolerance. `known`: the
        ends of their laps; where they are not known, states and Jacobians are those of coarse steps."""
        active = which
        failures = np.zeros(len(chase.lane), int)
        chase.forget()
        for number in range(FINE_PASSES):
            if not len(active):
                break
            first = known is None and number == 0
            if known is None or number > 0:
                course = self._course(chase, active, self.fine)
                end, ranges = self.lap(course, chase.state[active])
                chase.ranges[active] = ranges if first else chase.ranges[active]
            else:
                end = known
            change = _finite(end - chase.state[active])
            memory = chase.memory(NEW_STEPS_MEMORY if first else MEMORY)[active]
            chase.learn(active, change, memory)
            residual = chase.residual[active]
            failures[active] += ~(residual < FAILED * chase.before[active]) & (residual > NEARLY)
            going = ((residual >= TOLERANCE) | first) & (failures[active] < FAILURES)
            active, change, memory = active[going], change[going], memory[going]
            if number < FINE_PASSES - 1:
                chase.move(active, change, memory, first)
        return chase.residual < TOLERANCE


def _ranges(least: Real, greatest: Real) -> Real:
    """How far components went, never nothing."""
    size = np.maximum(np.abs(least), np.abs(greatest))
    return _finite(np.maximum(greatest - least, 1e-9 * size + 1e-30))


def _finite(change: Real) -> Real:
    return np.where(np.isfinite(change), change, 1.0)
