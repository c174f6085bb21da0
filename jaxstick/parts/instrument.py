"""What the sensors make of the motion and the friction force."""

from __future__ import annotations

import abc
from typing import Any, NamedTuple

import equinox as eqx

from jaxstick.parts.motion import Motion, Scalar


class Reading(NamedTuple):
    """What is recorded: displacement of the mass [m] and friction force on it [N]."""

    displacement: Scalar
    friction: Scalar


class AbstractInstrument(eqx.Module):
    """The measuring chain, with a private state where it has memory (a filter, a delay)."""

    def initial(self, motion: Motion, friction: Scalar) -> Any:
        """The private state of a chain that has long seen this motion and friction force [N]."""
        del motion, friction
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
