"""A mass between the contact and the force gauges, whose inertia is recorded as force."""

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


class ForceInertia(AbstractEffect):
    """The force is recorded as F + mass x'', with x'' the acceleration of the slider.

    A positive mass adds to what opposes the acceleration; where the gauges lie behind a part that the slider
    carries along, they miss that part's inertia and the mass is negative.
    """

    card: ClassVar[Card] = Card(
        title="Inertia of the force table in the force",
        family="measurement",
        symptom="The recorded force contains a part in proportion to the acceleration of the slider: a "
        "sinusoid in fast slip that grows with the square of the frequency, and steps at events.",
        explanation=(
            "Something with mass moves with the slider and lies between the rubbing surface and the gauges, "
            "or the table answers to the slider's own inertia because the line of force does not pass "
            "through its elastic centre. The gauges then read friction and mass times acceleration together. "
            "In the equation of motion that looks like another moving mass; the force against speed in slip "
            "shows it, most of all in the fastest run."
        ),
        remedy="Run once with the contact lifted: what the force channel shows then is inertia. Lighten what "
        "lies between contact and gauges, or record its acceleration and subtract.",
        source="d'Alembert's principle; E. O. Doebelin, Measurement Systems: Application and Design, 5th "
        "ed., McGraw-Hill 2004, on force transducers and their sensitivity to acceleration.",
    )
    mass: Float[Array, ""] | float = parameter(
        "kg", "mass whose inertia is recorded as force", null=0.0, typical=1.5e-3, default=0.0
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, instrument=_InertForce(oscillator.instrument, self.mass))


class _InertForce(AbstractForceLink):
    inner: AbstractInstrument
    mass: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        return friction + self.mass * motion.a
