"""A tape of the last values of a quantity that can be played back from the age it was made for."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.parts.motion import Scalar

LENGTH = 191
"""How many values the tape holds. One a step they reach back three periods of the contact's ring at 64 steps
on one of them. A prime, so that tapes side by side in memory do not compete for the same places of the cache.
"""


class Tape(NamedTuple):
    """A ring of values: that of node n of the time grid is entry n/stride, rounded up, modulo `LENGTH`, so
    that an entry ends as the last of `stride` nodes. `count` steps of length `step` [s] have been taped since
    node 0, where the value was `first`."""

    ring: Float[Array, " length"]
    count: Scalar
    step: Scalar
    stride: Scalar
    first: Scalar


def blank(value: Scalar) -> Tape:
    """A tape that begins with this value."""
    value = jnp.asarray(value)
    return Tape(jnp.full(LENGTH, value), 0.0, 1.0, 1.0, value)


def taped(tape: Tape, value: Scalar, step: Scalar, age: Scalar) -> Tape:
    """The tape with one value more, `step` seconds after the last, to be played back from this age [s]; all
    steps and ages are equal. Beyond what one value a step reaches, it keeps every second, third and so on."""
    count = tape.count + 1.0
    stride = jnp.maximum(jnp.ceil(jax.lax.stop_gradient(age / step) / (LENGTH - 2)), 1.0)
    ring = jax.lax.dynamic_update_index_in_dim(
        tape.ring, jnp.asarray(value), _entry(jnp.ceil(count / stride)), 0
    )
    return Tape(ring, count, step, stride, tape.first)


def played(tape: Tape, age: Scalar) -> Scalar:
    """The value `age` seconds ago, linear between the nodes that were kept; an age beyond the start plays the
    first value.

    At age 0 it is the last value and its derivative with respect to the age that of the last step.
    """
    target = (tape.count - jnp.minimum(age / tape.step, tape.count)) / tape.stride
    near = jnp.maximum(jnp.ceil(target) - 1, 0.0)
    share = target - near
    return (1 - share) * tape.ring[_entry(near)] + share * tape.ring[_entry(near + 1)]


def _entry(number: Scalar) -> Array:
    return (jnp.asarray(number) % LENGTH).astype(jnp.int32)
