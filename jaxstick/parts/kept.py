"""Intermediate results that the compiler is to work out once."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array

from jaxstick.parts.motion import Motion, Scalar


def kept(value: Scalar, motion: Motion) -> Array:
    """`value` divided by a number that is 1 whatever the motion.

    XLA's compiler for CPUs takes additions and products for free and repeats them in every result they lead
    to, and for every direction of a derivative; it keeps what comes out of a division. One division where
    many such paths part saves a third of the time of a derivative by thirty parameters.
    """
    one = jax.lax.stop_gradient(jnp.where(jnp.isnan(motion.t), 0.0, 1.0))
    return value / one
