"""A scale that is another for large values than for small ones."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from jaxstick.parameter import parameter
from jaxstick.parts.motion import Scalar

SPAN = (2.0, 2.0)
"""A scale that changes by more than some half over what it scales is another fault: one that clips, say."""


def bend_of(unit: str, of_what: str) -> Any:
    """The field of an effect that says by how much its scale grows with what it scales: not, unless
    stated."""
    return parameter(unit, f"growth of it with the {of_what}, relative", typical=0.3, span=SPAN, default=0.0)


def bent(value: Scalar, bend: Scalar) -> Scalar:
    """value (1 + bend |value|)."""
    return value * (1 + bend * jnp.abs(value))
