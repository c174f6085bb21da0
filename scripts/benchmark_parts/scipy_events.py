"""scipy's integrators lane by lane: smooth stretches of stick and slip, each ended by an event."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from scripts.benchmark_parts.lanes import Lanes

MOST_STRETCHES = 10_000


class _Lane:
    """The loaded contact of one lane as three vector fields: stick, and slip to either side.

    The limits of the stretches are those of `tests.reference.loaded`: slip begins where the force of the
    contact spring reaches the limit, and ends where the limit rises faster than the spring can follow.
    """

    def __init__(self, lanes: Lanes, lane: int):
        (
            self.m,
            self.K,
            drive_stiffness,
            self.c,
            self.A,
            self.B,
            self.C,
            self.D,
            self.k1,
            frequency,
            amplitude,
        ) = (float(constant[lane]) for constant in lanes)
        self.push = drive_stiffness * amplitude
        self.omega = 2 * math.pi * frequency

    def rest(self, t: float, x: float, v: float) -> float:
        """The force on the mass without friction [N]."""
        return self.push * math.sin(self.omega * t) - self.K * x - self.c * v

    def limit(self, speed: float) -> float:
        return self.A * math.exp(-self.B * max(speed, 0.0)) + self.C

    def stick(self, t: float, y: np.ndarray, origin: float, _: float) -> tuple[float, float]:
        x, v = y
        return v, (self.rest(t, x, v) - self.k1 * (x - origin)) / self.m

    def slip(self, t: float, y: np.ndarray, _: float, side: float) -> tuple[float, float]:
        x, v = y
        return v, (self.rest(t, x, v) - side * (self.limit(side * v) + self.D * side * v)) / self.m

    def breaks_forward(self, t: float, y: np.ndarray, origin: float, _: float) -> float:
        return self.k1 * (y[0] - origin) - self.limit(y[1])

    def breaks_backward(self, t: float, y: np.ndarray, origin: float, _: float) -> float:
        return -self.k1 * (y[0] - origin) - self.limit(-y[1])

    def outpaced(self, t: float, y: np.ndarray, _: float, side: float) -> float:
        x, v = y
        limit = self.limit(side * v)
        quickening = side * (self.rest(t, x, v) - side * limit) / self.m
        return -self.B * (limit - self.C) * quickening / self.k1 - side * v


def _event(function: Callable[..., float]) -> Any:
    """As solve_ivp wants it: terminal, upward crossings only."""

    def event(*arguments: Any) -> float:
        return function(*arguments)

    event.terminal = True  # pyright: ignore[reportFunctionMemberAccess]
    event.direction = 1.0  # pyright: ignore[reportFunctionMemberAccess]
    return event


def trace(lanes: Lanes, lane: int, method: str, tolerance: float) -> np.ndarray:
    """Displacement of one lane at its samples [m]; relative tolerance, and as much of 1 cm and 0.1 m/s."""
    model = _Lane(lanes, lane)
    times = lanes.times(lane)
    found = np.zeros(len(times))
    t, end, y = 0.0, float(times[-1]), np.zeros(2)
    origin, side = 0.0, 0.0
    leaves = [_event(model.breaks_forward), _event(model.breaks_backward)]
    settles = [_event(model.outpaced)]
    for _ in range(MOST_STRETCHES):
        inside = times[(times > t) & (times <= end)]
        if len(inside) == 0:
            return found
        solution = solve_ivp(
            model.slip if side else model.stick,
            (t, end),
            y,
            method,
            inside,
            events=settles if side else leaves,
            args=(origin, side),
            rtol=tolerance,
            atol=tolerance * np.array([1e-2, 1e-1]),
        )
        reached = len(solution.t)
        if reached:
            first = int(np.searchsorted(times, solution.t[0]))
            found[first : first + reached] = solution.y[0]
        if solution.status != 1:
            return found
        which = 0 if len(solution.t_events[0]) else 1
        t, y = float(solution.t_events[which][0]), solution.y_events[which][0]
        if side:
            origin, side = y[0] - side * model.limit(side * y[1]) / model.k1, 0.0
        else:
            side = 1.0 if which == 0 else -1.0
    raise RuntimeError(f"more than {MOST_STRETCHES} stretches of stick and slip in lane {lane}")


def simulate(lanes: Lanes, method: str, tolerance: float) -> np.ndarray:
    """Displacement of every lane at its samples, one lane after the other."""
    return np.array([trace(lanes, lane, method, tolerance) for lane in range(lanes.size)])
