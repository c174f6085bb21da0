"""Friction that changes along the track."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.friction import AbstractFriction
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.scaled_friction import AbstractScaledFriction


class PositionDependentFriction(AbstractEffect):
    """Multiplies the law by 1 + gradient s, s the place on the track [m], at s = 0 the law as it is."""

    card: ClassVar[Card] = Card(
        title="Friction grows along the track",
        family="friction",
        symptom=(
            "Both plateaus of the friction force widen towards one end of the stroke: plotted over x the "
            "loop is a wedge, open at one end. Stops near that end are longer."
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

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, friction=_Graded(oscillator.friction, self.gradient))


class _Graded(AbstractScaledFriction):
    inner: AbstractFriction
    gradient: Scalar

    def excess(self, motion: Motion) -> Scalar:
        return self.gradient * motion.slide
