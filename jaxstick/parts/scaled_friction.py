"""A friction law whose whole force is multiplied by a factor that place, time or drive decide."""

import abc
from typing import Any

import jax.numpy as jnp

from jaxstick.parts.friction import AbstractWrappedFriction
from jaxstick.parts.kept import kept
from jaxstick.parts.motion import Motion, Scalar

LEAST_FACTOR = 0.05
"""Below this share of the law's own force the factor has left the range in which it means anything."""


class AbstractScaledFriction(AbstractWrappedFriction):
    """The law `inner`, dry and viscous part alike times 1 + `excess`, but never times less than 0.05."""

    @abc.abstractmethod
    def excess(self, motion: Motion) -> Scalar:
        """The relative excess over the law's own force."""

    def limit(self, state: Any, motion: Motion) -> Scalar:
        return self.inner.limit(state, motion) * self._factor(motion)

    def viscous(self, state: Any, motion: Motion) -> Scalar:
        return self.inner.viscous(state, motion) * self._factor(motion)

    def _factor(self, motion: Motion) -> Scalar:
        return kept(jnp.maximum(1 + self.excess(motion), LEAST_FACTOR))
