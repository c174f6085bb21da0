"""A force channel that also reads where the slider is."""

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


class ForcePositionCrosstalk(AbstractEffect):
    """The force is recorded as F + slope x (1 + bend |x|), with x the displacement of the mass."""

    card: ClassVar[Card] = Card(
        title="Force channel reads the position too",
        family="measurement",
        symptom="The recorded force contains a part in proportion to the displacement that keeps its sign "
        "when the sliding reverses: both plateaus are tilted the same way over the stroke.",
        explanation=(
            "The slider's weight travels along the force table and bends its cantilevers differently at each "
            "end, or a cable or a leaf spring joins the slider to the table, which may stiffen along the way "
            "(bend). In the equation of motion the "
            "same tilt looks like a wrong stiffness, so it is the force against displacement in slip that "
            "tells. Friction that depends on the position tilts the two plateaus against each other."
        ),
        remedy="With no sliding, put a dead weight at several points of the table and record the force "
        "channel; wire the gauges so that the position of the load cancels.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "interfering inputs; the moment of a load that moves along a beam.",
    )
    slope: Float[Array, ""] | float = parameter(
        "N/m", "recorded force per displacement", null=0.0, typical=0.03, default=0.0
    )
    bend: Float[Array, ""] | float = bend_of("1/m", "displacement")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        instrument = _TiltedForce(oscillator.instrument, self.slope, self.bend)
        return dataclasses.replace(oscillator, instrument=instrument)


class _TiltedForce(AbstractForceLink):
    inner: AbstractInstrument
    slope: Scalar
    bend: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        return friction + self.slope * bent(motion.x, self.bend)
