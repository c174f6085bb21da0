"""What changes in the course of a run, less and less."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from jaxstick.parameter import parameter
from jaxstick.parts.motion import Scalar
from jaxstick.parts.slowed import TINY, slowed

STEADY = 1e9
"""A settling time [s] in which no run comes to rest."""
SPAN = (1e3, 1e5)
"""A search has to reach times that are as good as that one: where a run still settles by a hundredth, its
rate is wrong by half a hundredth; and times of no sample, after which a change may go on as the root of
time."""
RATES = (50.0, 1e3)
"""What settles soon, or goes as the root of time, is fast at first."""


def settling_time() -> Any:
    """The field of an effect that says after which time a change has come to rest: never, unless stated."""
    return parameter(
        "s", "time in which the change comes to rest", lower=1e-3, typical=30.0, span=SPAN, default=STEADY
    )


def settling_tail() -> Any:
    """The field of an effect that says how long its change goes on after that time: no longer, unless
    stated."""
    return parameter(
        "1",
        "how long the change goes on after that: 0 exponential, 1 logarithmic, 2 as the root of time",
        lower=0.0,
        upper=2.0,
        typical=0.5,
        default=0.0,
    )


def settling(t: Scalar, time: Scalar, tail: Scalar) -> Scalar:
    """What goes as t at first and at the rate (1 + tail t/time)^(-1/tail), which is exp(-t/time) for no
    tail: no more than `time` in the end, `time` log(1 + t/time) or `time` [sqrt(1 + 2 t/time) - 1] for a
    tail of 1 or 2."""
    age = t / time
    return time * _grown(slowed(age, tail), 1 - tail)


def _grown(exponent: Scalar, rest: Scalar) -> Scalar:
    """[1 - exp(-rest exponent)]/rest."""
    small = jnp.abs(rest * exponent) < TINY
    safe = jnp.where(small, 1.0, rest)
    return jnp.where(small, exponent * (1 - rest * exponent / 2), -jnp.expm1(-safe * exponent) / safe)
