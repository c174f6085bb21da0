"""Laws of friction in slip."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.parameter import parameter
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.part import AbstractPart


class AbstractFriction(AbstractPart):
    """The friction force in slip, -direction (limit + viscous |slide_rate|)."""

    @abc.abstractmethod
    def limit(self, state: Any, motion: Motion) -> Scalar:
        """The largest force the contact carries before it yields, at this motion [N]."""

    @abc.abstractmethod
    def viscous(self, state: Any, motion: Motion) -> Scalar:
        """The slope of the part of the force that grows with the sliding velocity [N s/m]."""

    def static(self, state: Any, motion: Motion) -> Scalar:
        """What the limit would be in this place and state if the contact were at rest [N]."""
        return self.limit(state, motion._replace(slide_rate=0.0))


class AbstractWrappedFriction(AbstractFriction):
    """A law that makes something else of the force of another one, `inner`, whose state is its own."""

    inner: eqx.AbstractVar[AbstractFriction]

    def initial(self, motion: Motion) -> Any:
        return self.inner.initial(motion)

    def advance(self, state: Any, motion: Motion, step: Scalar) -> Any:
        return self.inner.advance(state, motion, step)


def within(law: AbstractFriction, change: Callable[[AbstractFriction], AbstractFriction]) -> AbstractFriction:
    """The law with a change of the one that all others are wrapped around."""
    if isinstance(law, AbstractWrappedFriction):
        return dataclasses.replace(law, inner=within(law.inner, change))
    return change(law)


class ExponentialFriction(AbstractFriction):
    """F = -sign(v) [A exp(-B |v|) + C + D |v|], equation (2) of the 1987 paper.

    A + C is the static friction force, C its dynamic asymptote, B how fast it weakens with speed and D the
    viscous slope. They are forces, not coefficients of friction.
    """

    A: Float[Array, ""] | float = parameter(
        "N", "weakening: static less dynamic friction", lower=0.0, null=0.0
    )
    B: Float[Array, ""] | float = parameter("s/m", "decay of the weakening with speed", lower=0.0)
    C: Float[Array, ""] | float = parameter("N", "dynamic friction", lower=0.0, null=0.0)
    D: Float[Array, ""] | float = parameter("N s/m", "viscous slope", lower=0.0, null=0.0)

    def limit(self, state: Any, motion: Motion) -> Scalar:
        return self.A * jnp.exp(-self.B * jnp.abs(motion.slide_rate)) + self.C

    def viscous(self, state: Any, motion: Motion) -> Scalar:
        return self.D
