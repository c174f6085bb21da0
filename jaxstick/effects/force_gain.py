"""A wrong scale of the force channel."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.bend import bend_of, bent
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument
from jaxstick.parts.motion import Motion, Scalar


class ForceGain(AbstractEffect):
    """The force is recorded as F + gain F (1 + bend |F|)."""

    card: ClassVar[Card] = Card(
        title="Scale of the force channel is wrong",
        family="measurement",
        symptom="The recorded force is off by the same percentage in every phase of the motion; inertia, "
        "springs and force balance only if mass and stiffness are taken larger or smaller than they are.",
        explanation=(
            "The calibration factor of the force channel is wrong: a gauge factor, a bridge supply or an "
            "amplifier range was entered wrongly, a load path past the gauges takes its share, or the "
            "calibration was done at another point of the table. The friction constants come out off by the "
            "same percentage. Where the channel is not linear, the percentage grows or falls with the force "
            "(bend). A wrong scale of the displacement or a wrong mass looks alike, so that only a "
            "mass and a stiffness known from elsewhere tell them apart."
        ),
        remedy="Load the force table with known weights over a pulley, along the guide and at the height of "
        "the contact, in both directions; weigh the moving mass.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "static calibration.",
    )
    traces: ClassVar[tuple[str, ...]] = ("scale of the forces",)
    traces_in_motion: ClassVar[tuple[str, ...]] = ()
    gain: Float[Array, ""] | float = parameter(
        "1",
        "relative error of the force scale",
        lower=-0.5,
        upper=0.5,
        null=0.0,
        typical=0.03,
        default=0.0,
    )
    bend: Float[Array, ""] | float = bend_of("1/N", "force")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        instrument = _ScaledForce(oscillator.instrument, self.gain, self.bend)
        return dataclasses.replace(oscillator, instrument=instrument)


class _ScaledForce(AbstractForceLink):
    inner: AbstractInstrument
    gain: Scalar
    bend: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        return friction + self.gain * bent(friction, self.bend)
