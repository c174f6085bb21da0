"""Lags of first and second order, followed exactly while their input changes linearly over a step."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array

from jaxstick.parts.by_few import by_few
from jaxstick.parts.motion import Scalar
from jaxstick.parts.track import Trace

FASTEST = 50.0
"""A step in which a lag fades more often than this by its e-th part is as good as endless: exp(-50) is below
rounding."""

SLIGHTEST = 1e-3
"""The least curvature of a lag: below it the second pole is a thousand times faster than the first."""

NO_TIME = 1e-12
"""A time [s] in which nothing fades."""


class Lag(NamedTuple):
    """What leaves a lag, its rate times the lag's time, and what enters it, all in the unit of the input."""

    level: Scalar
    swing: Scalar
    entering: Scalar


class Fading(NamedTuple):
    """What a lag keeps over a step: behind an input that stands still, a gap becomes rest gap + odd swing,
    and a swing becomes rest swing - odd (gap + swing)/curvature. share: the lag's time over the step."""

    rest: Scalar
    odd: Scalar
    share: Scalar
    curvature: Scalar


def settled(value: Scalar, change: Scalar) -> Lag:
    """A lag behind an input that is `value` now and has long been changing by `change` in the lag's time."""
    return Lag(value - change, change, value)


def fading(step: Scalar, time: Scalar, curvature: Scalar) -> Fading:
    """What a lag keeps over a step [s].

        level + time level' + curvature time^2 level'' = input

    A curvature near 0 is one lag of first order, 1/4 two equal ones, 1/2 Butterworth's filter of second
    order; 1/(4 zeta^2) is an oscillator of damping ratio zeta. The solution is that of the differential
    equation, so no step is too long.
    """
    curvature = jnp.maximum(curvature, SLIGHTEST)
    span = step / jnp.maximum(time, step / (FASTEST * jnp.maximum(2 * curvature, 1.0)))
    slope = 1 / (2 * curvature)
    spread = jnp.sqrt(jnp.maximum(jnp.abs(1 - 4 * curvature), 1e-8))
    slow = jnp.exp(-2 * span / (1 + spread))
    fast = jnp.exp(-slope * span * (1 + spread))
    decay, angle = jnp.exp(-slope * span), slope * span * spread
    real = curvature < 0.25
    even = jnp.where(real, (slow + fast) / 2, decay * jnp.cos(angle))
    odd = jnp.where(real, (slow - fast) / 2, decay * jnp.sin(angle)) / (slope * spread)
    return Fading(even + slope * odd, odd, time / step, curvature)


def passed(lag: Lag, value: Scalar, fading: Fading) -> Lag:
    """The lag after a step over which it fades like this, its input having changed linearly to `value`.

    As the lag's time goes to 0 the lag vanishes, and its derivative with respect to the time is the rate of
    the input over the step.
    """
    drift = fading.share * (value - lag.entering)
    gap, rush = lag.level - lag.entering + drift, lag.swing - drift
    return Lag(
        value - drift + fading.rest * gap + fading.odd * rush,
        drift + fading.rest * rush - fading.odd * (gap + rush) / fading.curvature,
        value,
    )


def lagged(lag: Lag, value: Scalar, step: Scalar, time: Scalar, curvature: Scalar) -> Lag:
    """The lag one step later [s], its input having changed linearly to `value`."""
    return passed(lag, value, fading(step, time, curvature))


def followed(trace: Trace, time: Scalar, curvature: Scalar) -> Lag:
    """The lag at the end of a trace, which changes linearly from point to point and had long been what it is
    at its oldest.

    Of an input that changed by x' at each age s, x' rest(s) has not come through yet, and the integral of
    rest over ages is time (odd - rest).
    """
    return Lag(*by_few(_followed, jnp.stack([jnp.asarray(time), jnp.asarray(curvature)]), trace))


def _followed(numbers: Array, trace: Trace) -> Array:
    time, curvature = numbers
    lags, values = jnp.asarray(trace.lags), jnp.asarray(trace.values)
    kept = fading(jnp.maximum(lags[1:], NO_TIME), time, curvature)
    rest, odd = (jnp.concatenate([jnp.full(1, at), each]) for at, each in ((1.0, kept.rest), (0.0, kept.odd)))
    towards_older = jnp.diff(values) / jnp.diff(lags)
    missing = jnp.sum(towards_older * jnp.diff(rest - odd))
    swing = jnp.sum(towards_older * jnp.diff(rest))
    return jnp.stack([values[0] - time * missing, time * swing, values[0]])


class Trail(NamedTuple):
    """What leaves a lag of first order, and what enters it, in the unit of the input."""

    level: Scalar
    entering: Scalar


def trailed(trail: Trail, value: Scalar, step: Scalar, time: Scalar) -> Trail:
    """A lag of first order one step later [s], the input having changed linearly to `value`:

    level + time level' = input
    """
    drift = time * (value - trail.entering) / step
    decay = jnp.exp(-step / jnp.maximum(time, step / FASTEST))
    return Trail(value - drift + decay * (trail.level - trail.entering + drift), value)
