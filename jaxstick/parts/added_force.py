"""A rig on which one more force acts than its own."""

import abc
from typing import Any

import equinox as eqx

from jaxstick.parts.drive import Excitation
from jaxstick.parts.guide import Surface
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class AbstractAddedForce(AbstractRig):
    """The rig `inner` and an added force with a memory of its own (None where it needs none)."""

    inner: eqx.AbstractVar[AbstractRig]

    @abc.abstractmethod
    def added(self, memory: Any, motion: Motion) -> Scalar:
        """The added force on the mass [N]."""

    def begin(self, motion: Motion) -> Any:
        """The memory at the start of a motion."""
        del motion
        return None

    def carry(self, memory: Any, motion: Motion, step: Scalar) -> Any:
        """The memory one step later [s]; `motion` is the motion at the end of the step."""
        del motion, step
        return memory

    def initial(self, motion: Motion) -> Any:
        return self.inner.initial(motion), self.begin(motion)

    def advance(self, state: Any, motion: Motion, step: Scalar) -> Any:
        inner, memory = state
        return self.inner.advance(inner, motion, step), self.carry(memory, motion, step)

    def surface(self, excitation: Excitation) -> Surface:
        return self.inner.surface(excitation)

    def inertia(self) -> Scalar:
        return self.inner.inertia()

    def force(self, state: Any, motion: Motion) -> Scalar:
        inner, memory = state
        return self.inner.force(inner, motion) + self.added(memory, motion)
