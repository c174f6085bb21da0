"""What the sensors make of the motion and the friction force."""

from __future__ import annotations

import abc
import math
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp

from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.track import Trace


class Reading(NamedTuple):
    """What is recorded: displacement of the mass [m] and friction force on it [N]."""

    displacement: Scalar
    friction: Scalar


class Past(NamedTuple):
    """What is known, at the start of a motion, of the time before it.

    rate, at which the friction force changes at the start [N/s]; impulse, the integral of the friction force
    as it was recorded, from the beginning of the run to the start [N s], and impulse_sum, the integral of
    that [N s^2]; recorded, that force at the start [N], not a number where nobody knows; shown, that force at
    times before the start [N], None where none is known.
    """

    rate: Scalar = 0.0
    impulse: Scalar = 0.0
    impulse_sum: Scalar = 0.0
    recorded: Scalar = math.nan
    shown: Trace | None = None

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
