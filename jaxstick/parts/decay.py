"""The mean of a decay over a step."""

from __future__ import annotations

import jax.numpy as jnp

from jaxstick.parts.motion import Scalar

SMALL = 1e-9


def mean_decay(exponent: Scalar) -> Scalar:
    """(1 - exp(-z))/z, the mean of exp(-s) for s from 0 to z >= 0, with its derivative at z = 0 as well."""
    small = exponent < SMALL
    return jnp.where(small, 1 - exponent / 2, -jnp.expm1(-exponent) / jnp.where(small, 1.0, exponent))
