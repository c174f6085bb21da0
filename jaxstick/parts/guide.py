"""The surface that the mass rubs on."""

from __future__ import annotations

import abc
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from jaxstick.parts.drive import Excitation


class Surface(NamedTuple):
    """Displacement, velocity and acceleration of the rubbing surface [m, m/s, m/s^2]."""

    position: Array
    rate: Array
    acceleration: Array


class AbstractGuide(eqx.Module):
    """Says how the surface under the mass moves."""

    @abc.abstractmethod
    def surface(self, excitation: Excitation) -> Surface:
        """The motion of the rubbing surface under this excitation."""


class GroundGuide(AbstractGuide):
    """A guide fixed to the ground: the sliding velocity is x'."""

    def surface(self, excitation: Excitation) -> Surface:
        still = jnp.zeros_like(excitation.y)
        return Surface(still, still, still)


class BaseGuide(AbstractGuide):
    """A guide carried by the base: the sliding velocity is x' - y'."""

    def surface(self, excitation: Excitation) -> Surface:
        return Surface(excitation.y, excitation.y_rate, excitation.y_acceleration)
