"""Friction that changes along the track."""

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


class PositionDependentFriction(AbstractEffect):
    """Multiplies the law by 1 + gradient p + curvature p^2, p = length tanh(s/length), s the place on the
    track [m].

    At s = 0 the law is as it is; friction changes evenly along the track where `length` is far longer than
    the stroke and nothing is curved. A track worn in the middle of the stroke has a curvature above 0.
    """

    card: ClassVar[Card] = Card(
        title="Friction changes along the track",
        family="friction",
        symptom=(
            "Both plateaus of the friction force widen towards one end of the stroke, or towards both: "
            "plotted over x the loop is a wedge, open at one end, or has a waist. Stops where it is wide are "
            "longer."
        ),
        explanation=(
            "The track is not the same everywhere: worn in the middle or at one end, dirty, differently "
            "lubricated, not parallel to the slider so that the normal load grows along it. An offset of "
            "the force reading shifts both branches of the loop the same way; this shifts them apart."
        ),
        remedy=(
            "Move the middle of the stroke along the track and repeat: the wedge stays where it was on the "
            "track. Clean, run in or realign the track."
        ),
        source=(
            "Armstrong, Friction: experimental determination, modeling and compensation, Proc. IEEE Int. "
            "Conf. Robotics and Automation (1988) 1422."
        ),
    )
    gradient: Float[Array, ""] | float = parameter(
        "1/m", "relative change of friction along the track", null=0.0, typical=0.1, default=0.0
    )
    curvature: Float[Array, ""] | float = parameter(
        "1/m^2",
        "relative change of friction towards both ends of the track",
        null=0.0,
        typical=0.1,
        default=0.0,
    )
    length: Float[Array, ""] | float = parameter(
        "m",
        "distance from the middle at which friction changes no more",
        lower=1e-9,
        typical=2.0,
        span=(10.0, 50.0),
        default=1e3,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        graded = _Graded(oscillator.friction, self.gradient, self.curvature, self.length)
        return dataclasses.replace(oscillator, friction=graded)


class _Graded(AbstractScaledFriction):
    inner: AbstractFriction
    gradient: Scalar
    curvature: Scalar
    length: Scalar

    def excess(self, motion: Motion) -> Scalar:
        place = self.length * jnp.tanh(motion.slide / self.length)
        return (self.gradient + self.curvature * place) * place
