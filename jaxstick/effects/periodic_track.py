"""Friction that comes and goes along the track with a fixed wavelength."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from jaxtyping import Array, Float
from scipy.signal import lombscargle

from jaxstick.effect import AbstractEffect, Card, Leftover
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.friction import AbstractFriction
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.scaled_friction import AbstractScaledFriction
from jaxstick.turns import sine_and_cosine

SLIDING = 0.1
"""The mass surely slides above this share of its top speed."""
MOST_WAVES, FINENESS = 100, 6
"""Wavelengths are sought down to one so-manieth of the stroke, so many for every wave more on it."""


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

    @classmethod
    def read_off(cls, leftover: Leftover) -> Mapping[str, float]:
        """The wavelength at which friction, as a share of what is modelled, has its highest line over place
        (periodogram of Lomb, Astrophysics and Space Science 39 (1976) 447)."""
        speed = np.abs(leftover.slide_rate)
        sliding = speed > SLIDING * speed.max(initial=0.0)
        place, friction = leftover.slide[sliding], leftover.friction[sliding]
        stroke = float(np.ptp(place)) if len(place) else 0.0
        if not stroke > 0:
            return {}
        share = leftover.beyond[sliding] * np.sign(friction) / np.median(np.abs(friction))
        waves = np.arange(FINENESS, MOST_WAVES * FINENESS + 1) / FINENESS
        line = lombscargle(place, share - share.mean(), 2 * np.pi * waves / stroke)
        return {"wavelength": stroke / float(waves[int(np.argmax(line))])}

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
