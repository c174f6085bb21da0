"""A gear that shakes the mass at a frequency of its own, which is no effect of the shelf."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp

from jaxstick.effect import AbstractEffect, Card
from jaxstick.effects.stribeck_shape import StribeckShape
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.drive import AbstractDrive, Excitation, Extent

GEAR = 13.7
"""The frequency of a force that no channel shows [Hz]."""


class Geared(AbstractDrive):
    """A drive with a force that oscillates beside it."""

    inner: AbstractDrive
    size: Any

    def at(self, t: Any) -> Excitation:
        seen = self.inner.at(t)
        return seen._replace(u=seen.u + self.size * jnp.sin(2 * jnp.pi * GEAR * jnp.asarray(t)))

    def extent(self) -> Extent:
        return self.inner.extent()


class Gear(AbstractEffect):
    """A gear that shakes the mass."""

    card: ClassVar[Card] = StribeckShape.card
    size: Any = parameter("N", "amplitude", null=0.0, typical=1.0, default=0.0)

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, drive=Geared(oscillator.drive, self.size))
