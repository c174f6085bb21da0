"""A normal load that varies with the phase of the drive."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.friction import AbstractFriction
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.scaled_friction import AbstractScaledFriction


class LoadVariation(AbstractEffect):
    """Multiplies the law by 1 + in_phase s + quadrature c + at_ends (2 s^2 - 1) + before_ends 2 s c.

    s = y/Y and c = y'/Y', base displacement and velocity, each over its own amplitude in the run, are sine
    and cosine of the drive's phase without its frequency having to be known, and stand for them where the
    drive is no sine; the last two terms go at twice the phase. Where only a force drives, u/U takes the place
    of y/Y, and c is 0.
    """

    card: ClassVar[Card] = Card(
        title="Normal load varies with the drive",
        family="friction",
        symptom=(
            "The level of friction rises and falls once or twice per cycle of the drive, in both directions "
            "of sliding alike, with a phase fixed to the base and not to where the slider is."
        ),
        explanation=(
            "Something that moves with the drive presses on the slider: the table lifts or tilts as it "
            "travels, the spring pulls at an angle or above the contact, the motor shakes the frame. "
            "Friction follows the normal load."
        ),
        remedy=(
            "Record the normal load or the vertical acceleration of the slider. Align the spring with the "
            "plane of contact; change amplitude or frequency: a load moved by inertia grows with their "
            "product."
        ),
        source=(
            "Anderson, Ferri, Behavior of a single-degree-of-freedom system with a generalized friction "
            "law, J. Sound Vib. 140 (1990) 287."
        ),
    )
    in_phase: Float[Array, ""] | float = parameter(
        "1",
        "relative amplitude of the load in phase with the base's displacement",
        null=0.0,
        typical=0.03,
        default=0.0,
    )
    quadrature: Float[Array, ""] | float = parameter(
        "1",
        "relative amplitude of the load in phase with the base's velocity",
        null=0.0,
        typical=0.03,
        default=0.0,
    )
    at_ends: Float[Array, ""] | float = parameter(
        "1",
        "relative amplitude of the load that is greatest at either end of the base's stroke",
        null=0.0,
        typical=0.03,
        default=0.0,
    )
    before_ends: Float[Array, ""] | float = parameter(
        "1",
        "relative amplitude of the load at twice the phase that is greatest an eighth of a cycle before them",
        null=0.0,
        typical=0.03,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        extent = oscillator.drive.extent()
        pressed = _Pressed(
            oscillator.friction,
            (self.in_phase, self.quadrature, self.at_ends, self.before_ends),
            _reciprocal(extent.y),
            _reciprocal(extent.y_rate),
            jnp.where(jnp.asarray(extent.y) == 0, _reciprocal(extent.u), 0.0),
        )
        return dataclasses.replace(oscillator, friction=pressed)


def _reciprocal(size: Scalar) -> Array:
    """1/size, but 0 of nothing."""
    size = jnp.asarray(size)
    return jnp.where(size == 0, 0.0, 1 / jnp.where(size == 0, 1.0, size))


class _Pressed(AbstractScaledFriction):
    inner: AbstractFriction
    load: tuple[Scalar, Scalar, Scalar, Scalar]
    per_place: Scalar
    per_rate: Scalar
    per_force: Scalar

    def excess(self, motion: Motion) -> Scalar:
        in_phase, quadrature, at_ends, before_ends = self.load
        sine = self.per_place * motion.y + self.per_force * motion.u
        cosine = self.per_rate * motion.y_rate
        twice = at_ends * (2 * sine**2 - 1) + before_ends * 2 * sine * cosine
        return in_phase * sine + quadrature * cosine + twice
