"""Friction that comes and goes along the track with a fixed wavelength."""

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
from jaxstick.turns import sine_and_cosine


class PeriodicTrack(AbstractEffect):
    """Multiplies the law by 1 + cosine cos(2 pi s/wavelength) + sine sin(2 pi s/wavelength), s the place."""

    card: ClassVar[Card] = Card(
        title="Friction varies periodically along the track",
        family="friction",
        symptom=(
            "In slip the friction force carries a ripple that is a line in its spectrum over place, not "
            "over time: its frequency rises and falls with the speed, and it repeats at the same places."
        ),
        explanation=(
            "The track carries a pattern: grinding or milling marks, balls or teeth passing, waviness, rows "
            "of wear from earlier stops. The slider meets more and less resistance in turn as it passes."
        ),
        remedy=(
            "Move the slider along the track by half a wavelength: the ripple turns over. Lap the track, or "
            "replace the bearing or screw whose pitch the wavelength matches."
        ),
        source="Armstrong-Helouvry, Control of Machines with Friction, Kluwer, Boston 1991.",
    )
    cosine: Float[Array, ""] | float = parameter(
        "1", "relative amplitude, part that is greatest at place 0", null=0.0, typical=0.03, default=0.0
    )
    sine: Float[Array, ""] | float = parameter(
        "1", "relative amplitude, part a quarter wavelength on", null=0.0, typical=0.03, default=0.0
    )
    wavelength: Float[Array, ""] | float = parameter(
        "m", "length of one period of the track", lower=1e-6, typical=0.1, default=1e-3
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        wavy = _Wavy(oscillator.friction, self.cosine, self.sine, 1 / self.wavelength)
        return dataclasses.replace(oscillator, friction=wavy)


class _Wavy(AbstractScaledFriction):
    inner: AbstractFriction
    cosine: Scalar
    sine: Scalar
    waves_per_metre: Scalar

    def excess(self, motion: Motion) -> Scalar:
        sine, cosine = sine_and_cosine(self.waves_per_metre * motion.slide)
        return self.cosine * cosine + self.sine * sine
