"""A wrong zero of the force channel."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument
from jaxstick.parts.motion import Motion, Scalar


class ForceOffset(AbstractEffect):
    """The force is recorded as F + offset."""

    card: ClassVar[Card] = Card(
        title="Zero of the force channel is off",
        family="measurement",
        symptom="The recorded force is shifted by the same amount in slip and in stick, forward and "
        "backward; the displacement is as predicted.",
        explanation=(
            "The force channel was not set to zero, or was set to zero while the mass hung in its springs "
            "with friction holding it. Friction that differs between the directions shifts the plateaus too, "
            "but it follows the law's dependence on speed and moves the mass; a constant force moves the "
            "mass and leaves the recorded friction alone. Amplifiers drift and zeros are set anew: no two "
            "runs need have the same."
        ),
        remedy="Lift the slider off and record the force channel for ten seconds before and after each run.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "zero error and bias.",
    )
    changes: ClassVar[bool] = True
    offset: Float[Array, ""] | float = parameter(
        "N", "recorded force where there is none", null=0.0, typical=0.02, by_run=True, default=0.0
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, instrument=_ShiftedForce(oscillator.instrument, self.offset))


class _ShiftedForce(AbstractForceLink):
    inner: AbstractInstrument
    offset: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        return friction + self.offset
