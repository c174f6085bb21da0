"""A link of the measuring chain through which the friction force passes on its way to an inner instrument."""

from __future__ import annotations

import abc
from typing import Any, NamedTuple

import equinox as eqx

from jaxstick.parts.instrument import AbstractInstrument, Past, Reading
from jaxstick.parts.motion import Motion, Scalar


class LinkState(NamedTuple):
    """The private states of a link and of the instrument behind it."""

    own: Any
    inner: Any


class AbstractForceLink(AbstractInstrument):
    """Changes the friction force before the inner instrument takes it in.

    Of several links the one that was put around the others last stands nearest to the contact, and each is
    worked out once a step. A link without memory keeps the defaults of `begin` and `follow`.
    """

    inner: eqx.AbstractVar[AbstractInstrument]

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> Any:
        """The link's own private state at the start of a motion."""
        del motion, friction, past
        return None

    def follow(self, own: Any, motion: Motion, friction: Scalar, step: Scalar) -> Any:
        """The link's own private state one step later [s]; motion and force [N] are those at its end."""
        del motion, friction, step
        return own

    @abc.abstractmethod
    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        """The force [N] that leaves the link when `friction` [N] enters it."""

    def initial(self, motion: Motion, friction: Scalar, past: Past) -> LinkState:
        own = self.begin(motion, friction, past)
        return LinkState(own, self.inner.initial(motion, self.passed(own, motion, friction), past))

    def advance(self, state: LinkState, motion: Motion, friction: Scalar, step: Scalar) -> LinkState:
        own = self.follow(state.own, motion, friction, step)
        return LinkState(
            own, self.inner.advance(state.inner, motion, self.passed(own, motion, friction), step)
        )

    def read(self, state: LinkState, motion: Motion, friction: Scalar) -> Reading:
        return self.inner.read(state.inner, motion, self.passed(state.own, motion, friction))
