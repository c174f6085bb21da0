"""A tape of the last values of a quantity, one a step, that can be played back from any age."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.parts.motion import Scalar

LENGTH = 191
"""How many steps the tape reaches back: three periods of the contact's ring at 64 steps on one of them. A
prime, so that tapes side by side in memory do not compete for the same places of the cache."""


class Tape(NamedTuple):
    """A ring of values: that of node n of the time grid is entry n modulo `LENGTH`. `count` steps of length
    `step` [s] have been taped since node 0, where the value was `first`."""

    ring: Float[Array, " length"]
    count: Scalar
    step: Scalar
    first: Scalar


def blank(value: Scalar) -> Tape:
    """A tape that begins with this value."""
    value = jnp.asarray(value)
    return Tape(jnp.full(LENGTH, value), 0.0, 1.0, value)


def taped(tape: Tape, value: Scalar, step: Scalar) -> Tape:
    """The tape with one value more, `step` seconds after the last; all steps are equal."""
    count = tape.count + 1.0
    ring = jax.lax.dynamic_update_index_in_dim(tape.ring, jnp.asarray(value), _entry(count), 0)
    return Tape(ring, count, step, tape.first)


def played(tape: Tape, age: Scalar) -> Scalar:
    """The value `age` seconds ago, linear between nodes; an age beyond the start or the length of the tape
    plays its oldest value.

    At age 0 it is the last value and its derivative with respect to the age that of the last step.
    """
    target = tape.count - jnp.minimum(age / tape.step, jnp.minimum(tape.count, LENGTH - 1.0))
    near = jnp.maximum(jnp.ceil(target) - 1, 0.0)
    share = target - near
    return (1 - share) * tape.ring[_entry(near)] + share * tape.ring[_entry(near + 1)]


def _entry(number: Scalar) -> Array:
    return (jnp.asarray(number) % LENGTH).astype(jnp.int32)
