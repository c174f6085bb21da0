"""What changes in the course of a run, less and less."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from jaxstick.parameter import parameter
from jaxstick.parts.motion import Scalar

STEADY = 1e9
"""A settling time [s] in which no run comes to rest."""
SPAN = (30.0, 1e5)
"""A search has to reach times that are as good as this one: where a run still settles by a hundredth, its
rate is wrong by half a hundredth."""


def settling_time() -> Any:
    """The field of an effect that says after which time a change has come to rest: never, unless stated."""
    return parameter(
        "s", "time in which the change comes to rest", lower=1e-3, typical=30.0, span=SPAN, default=STEADY
    )


def settling(t: Scalar, time: Scalar) -> Scalar:
    """`time` (1 - exp(-t/time)): t at first, no more than `time` in the end."""
    return -time * jnp.expm1(-t / time)
