"""From event to event: integrate one mode, find where it ends, enter the next.

Steps are of order eight with error control; the end of a mode is placed by exact steps, not by their
interpolant. An exit that is passed and passed back between two steps is found by its rate changing sign. A
mode that begins on the boundary of an exit (a slip that begins at w = 0) ends there only if it does not first
move away from it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import inf, ulp
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from tests.reference.dop853 import Dense, error, step
from tests.reference.drive import Drive
from tests.reference.mode import Entry, Exit, Mode

RELATIVE_TOLERANCE = 1e-11
SIZE_OF_POSITION = 1e-2
SIZE_OF_VELOCITY = 1e-1
"""Sizes [m, m/s] below which the tolerance is no longer relative."""

LONGEST_STEP = 0.5
"""Longest step in units of the drive's time scale (a twelfth of a cycle of a sine)."""

MOST_EVENTS_AT_ONCE = 20


@dataclass(frozen=True)
class Run:
    """x [m], v [m/s], F [N], z [m] at `time` [s]; `events`: (time, kind of the mode that begins there)."""

    time: np.ndarray
    x: np.ndarray
    v: np.ndarray
    F: np.ndarray
    z: np.ndarray
    events: list[tuple[float, str]]

    def count(self, kind: str, start: float, end: float) -> int:
        """How many modes of `kind` begin in start <= t < end [s]."""
        return sum(start <= t < end and kind == k for t, k in self.events)


class _Point(NamedTuple):
    """The motion at an instant, with the values of the mode's exits and (in sign) their rates."""

    t: float
    x: float
    v: float
    a: float
    values: list[float]
    rates: list[float]


class _Step(NamedTuple):
    """A step of length h, its end, the motion at its fraction theta: interpolated or by a step of its own."""

    h: float
    x1: float
    v1: float
    a1: float
    inside: Callable[[float], tuple[float, float]]
    exact: Callable[[float], tuple[float, float]]


class _Samples:
    """Collects the readings at the wanted times."""

    def __init__(self, times: list[float]) -> None:
        self.times, self.rows = times, []

    def read(self, mode: Mode, t: float, x: float, v: float) -> None:
        self.rows.append((x, v, mode.friction(t, x, v), mode.deflection(t, x, v)))

    def read_inside(self, mode: Mode, start: float, taken: _Step, end: float) -> None:
        """Read at all wanted times of the step that are below `end`."""
        while len(self.rows) < len(self.times) and self.times[len(self.rows)] < end:
            t = self.times[len(self.rows)]
            self.read(mode, t, *taken.inside((t - start) / taken.h))


def march(
    entry: Entry, x: float, times: np.ndarray, drive: Drive, first_step: float, tolerance: float
) -> Run:
    """Follow the modes from `entry` at times[0] to times[-1]; `times` [s] must increase.

    RuntimeError where events pile up at one instant: the model has no continuation there.
    """
    samples = _Samples([float(t) for t in times])
    if any(b <= a for a, b in pairwise(samples.times)):
        raise ValueError("the times must increase")
    start, end = samples.times[0], samples.times[-1]
    breaks = [*sorted(b for b in drive.breakpoints if start < b < end), end]
    longest = LONGEST_STEP * drive.time_scale
    first_step = min(first_step, longest)
    mode = entry.mode
    here, h, fresh, pile = _enter(mode, start, x, entry.v, first_step), first_step, True, 0
    events = [(start, mode.kind)]
    while here.t < end:
        goal = end if breaks[0] == end else breaks[0] - 8.0 * ulp(breaks[0])
        taken, h = _take(mode, here, min(h, longest, goal - here.t), tolerance)
        t1 = goal if taken.h >= goal - here.t else here.t + taken.h
        there = _look(mode, t1, taken.x1, taken.v1, taken.a1, taken.h)
        theta, way_out = _first_exit(mode, taken, here, there, fresh)
        if way_out is not None:
            t1 = here.t + theta * taken.h
            samples.read_inside(mode, here.t, taken, t1)
            pile = pile + 1 if theta * taken.h <= 8.0 * ulp(t1) else 0
            if pile > MOST_EVENTS_AT_ONCE:
                raise RuntimeError(f"events pile up at t = {t1} s")
            x, v = taken.exact(theta)
            mode, v = way_out.enter(t1, x, v)
            events.append((t1, mode.kind))
            here, h, fresh = _enter(mode, t1, x, v, first_step), first_step, True
            continue
        samples.read_inside(mode, here.t, taken, t1)
        here, fresh = there, False
        if t1 == goal < end:
            here, h, fresh = _enter(mode, breaks.pop(0), there.x, there.v, first_step), first_step, True
    samples.read(mode, here.t, here.x, here.v)
    x_s, v_s, F_s, z_s = np.array(samples.rows).T
    return Run(np.array(samples.times), x_s, v_s, F_s, z_s, events)


def _enter(mode: Mode, t: float, x: float, v: float, h: float) -> _Point:
    return _look(mode, t, x, v, mode.acceleration(t, x, v), h)


def _look(mode: Mode, t: float, x: float, v: float, a: float, h: float) -> _Point:
    """The exits' values, and the signs of their rates from a look ahead by a small part of the step h."""
    d = 1e-3 * h
    x_d, v_d = x + d * (v + 0.5 * d * a), v + d * a
    values = [way.value(t, x, v) for way in mode.exits]
    rates = [way.value(t + d, x_d, v_d) - value for way, value in zip(mode.exits, values, strict=True)]
    return _Point(t, x, v, a, values, rates)


def _take(mode: Mode, here: _Point, h: float, tolerance: float) -> tuple[_Step, float]:
    """One step of at most h, and the length to try next."""
    t, x, v, a = here.t, here.x, here.v, here.a
    acceleration, follow = mode.acceleration, mode.follow
    if follow is not None:
        x1, v1 = follow(t + h)

        def along(theta: float) -> tuple[float, float]:
            return follow(t + theta * h)

        return _Step(h, x1, v1, acceleration(t + h, x1, v1), along, along), inf
    while True:
        stages = step(acceleration, t, x, v, a, h)
        miss = error(
            stages,
            tolerance * (SIZE_OF_POSITION + max(abs(x), abs(stages.x1))),
            tolerance * (SIZE_OF_VELOCITY + max(abs(v), abs(stages.v1))),
        )
        if miss < 1.0:
            break
        h *= max(0.2, 0.9 * miss**-0.125)
    a1 = acceleration(t + h, stages.x1, stages.v1)
    dense: list[Dense] = []

    def inside(theta: float) -> tuple[float, float]:
        if not dense:
            dense.append(Dense(acceleration, stages, a1))
        return dense[0].at(theta)

    def exact(theta: float) -> tuple[float, float]:
        part = step(acceleration, t, x, v, a, theta * h)
        return part.x1, part.v1

    grow = 6.0 if miss == 0.0 else min(6.0, max(0.3, 0.9 * miss**-0.125))
    return _Step(h, stages.x1, stages.v1, a1, inside, exact), h * grow


def _first_exit(
    mode: Mode, taken: _Step, here: _Point, there: _Point, fresh: bool
) -> tuple[float, Exit | None]:
    """The fraction of the step at which the mode ends and the exit it takes; (1, None) where it goes on."""
    first: tuple[float, Exit | None] = (1.0, None)
    for i, way in enumerate(mode.exits):
        lower, upper = 0.0, 1.0
        if there.values[i] <= 0.0:
            if fresh or here.rates[i] <= 0.0 or there.rates[i] >= 0.0:
                continue
            upper, height = _extremum(way, here.t, taken, 1.0)
            if height <= 0.0:
                continue
        starts_inside = here.values[i] < 0.0
        if not starts_inside:
            lower, depth = _extremum(way, here.t, taken, -1.0)
            starts_inside = depth < 0.0
        theta = _crossing(way, here.t, taken, lower, upper) if starts_inside else 0.0
        if theta < first[0] or first[1] is None:
            first = (theta, way)
    return first


def _crossing(way: Exit, t: float, taken: _Step, lower: float, upper: float) -> float:
    """Where in lower < theta <= upper the value rises to zero: on the interpolant, then by exact steps."""

    def value(theta: float) -> float:
        return way.value(t + theta * taken.h, *taken.inside(theta))

    if value(upper) <= 0.0:
        return upper
    theta: float = brentq(value, lower, upper, xtol=1e-12)  # pyright: ignore[reportAssignmentType]
    slope = (value(theta + 1e-4) - value(theta - 1e-4)) / 2e-4
    for _ in range(2 if slope > 0.0 else 0):
        miss = way.value(t + theta * taken.h, *taken.exact(theta))
        theta = min(max(theta - miss / slope, lower), upper)
    return theta


def _extremum(way: Exit, t: float, taken: _Step, sign: float) -> tuple[float, float]:
    """Where in the step the exit's value is largest (sign 1) or least (-1), and that value."""

    def value(theta: float) -> float:
        return sign * way.value(t + theta * taken.h, *taken.inside(theta))

    low, high, ratio = 0.0, 1.0, 0.6180339887498949
    p, q = high - ratio * (high - low), low + ratio * (high - low)
    at_p, at_q = value(p), value(q)
    while high - low > 1e-7:
        if at_p > at_q:
            high, q, at_q = q, p, at_p
            p = high - ratio * (high - low)
            at_p = value(p)
        else:
            low, p, at_p = p, q, at_q
            q = low + ratio * (high - low)
            at_q = value(q)
    theta = 0.5 * (low + high)
    return theta, sign * value(theta)
