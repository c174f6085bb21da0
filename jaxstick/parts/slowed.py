"""What grows in proportion at first and with the logarithm in the end."""

from __future__ import annotations

import jax.numpy as jnp

from jaxstick.parts.motion import Scalar

TINY = 1e-5
"""Of less than so much no more than the square counts in a series."""


def slowed(x: Scalar, tail: Scalar) -> Scalar:
    """log(1 + tail x)/tail, which is x for no tail; of x and tail from zero on."""
    small = tail * x < TINY
    safe = jnp.where(small, 1.0, tail)
    return jnp.where(small, x * (1 - tail * x / 2), jnp.log1p(safe * x) / safe)
