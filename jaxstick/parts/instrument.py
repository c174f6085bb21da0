"""What the sensors make of the motion and the friction force."""

from __future__ import annotations

import abc
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp

from jaxstick.parts.before import Before
from jaxstick.parts.motion import Motion, Scalar


class Reading(NamedTuple):
    """What is recorded: displacement of the mass [m] and friction force on it [N]."""

    displacement: Scalar
    friction: Scalar


class Past(NamedTuple):
    """How a motion comes to its start: rate, at which the friction force changes there [N/s], and what is
    known of the time before."""

    rate: Scalar = 0.0
    before: Before = Before()

    def change(self, friction: Scalar, span: Scalar) -> Scalar:
        """By how much the friction force, `friction` [N] at the start, changed in the last `span` seconds:
        at the rate of the start, but by no more than itself, since a force in full swing has not swung for
        long."""
        return jnp.clip(jnp.asarray(self.rate) * span, -jnp.abs(friction), jnp.abs(friction))


class AbstractInstrument(eqx.Module):
    """The measuring chain, with a private state where it has memory (a filter, a delay)."""

    def initial(self, motion: Motion, friction: Scalar, past: Past) -> Any:
        """The private state at the start of a motion, with the friction force [N] there.

        A motion may be picked up in the middle of a record; the state is the likeliest that `past` allows.
        """
        del motion, friction, past
        return None

    def advance(self, state: Any, motion: Motion, friction: Scalar, step: Scalar) -> Any:
        """The private state one step later [s]; motion and friction force [N] are those at its end."""
        del motion, friction, step
        return state

    @abc.abstractmethod
    def read(self, state: Any, motion: Motion, friction: Scalar) -> Reading:
        """The reading at this instant."""


class IdealInstrument(AbstractInstrument):
    """Sensors that tell the truth at once."""

    def read(self, state: Any, motion: Motion, friction: Scalar) -> Reading:
        return Reading(motion.x, friction)
