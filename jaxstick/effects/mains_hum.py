"""Hum of the mains on the force channel."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument
from jaxstick.parts.motion import Motion, Scalar

SILENT = 1e-9
"""A hum [N] of which no phase can be told."""


def _harmonic(meaning: str) -> Any:
    return parameter("1", meaning, lower=-1.0, upper=1.0, typical=0.2, default=0.0)


class MainsHum(AbstractEffect):
    """The force is recorded as F + a [cos(p) + second_even cos(2 p) + second_odd sin(2 p)
    + third_even cos(3 p) + third_odd sin(3 p)].

    a cos(p) = cosine cos(2 pi frequency t) + sine sin(2 pi frequency t): p is the phase of the mains in the
    run, with which the harmonics keep step in every run, the second that of rectifiers, the third that of
    transformers near saturation.
    It acts on the force channel: the millivolts of a strain gauge bridge pick up what the volts of a
    displacement transducer, demodulated from a carrier, do not.
    """

    card: ClassVar[Card] = Card(
        title="Mains hum on the force channel",
        family="measurement",
        symptom="The recorded force carries a line at 50 or 60 Hz, and perhaps at two and three times that, "
        "of the same height in stick and in slip and in every run, whatever the frequency of the excitation.",
        explanation=(
            "The leads of the gauge bridge form a loop in the magnetic field of transformers and motors, or "
            "bridge and amplifier are earthed at two points. The hum rides on the signal and is not in the "
            "motion. Its phase differs from run to run, since no run starts in step with the mains."
        ),
        remedy="Twist and shield the leads, earth the shield at one end, keep it away from the drive's "
        "inverter; use a carrier-frequency amplifier; or take the line out of the record.",
        source="H. W. Ott, Electromagnetic Compatibility Engineering, Wiley 2009, on cabling and grounding.",
    )
    cosine: Float[Array, ""] | float = parameter(
        "N",
        "part of the hum in step with the start of the run",
        null=0.0,
        typical=0.01,
        by_run=True,
        default=0.0,
    )
    sine: Float[Array, ""] | float = parameter(
        "N", "part of the hum a quarter period later", null=0.0, typical=0.01, by_run=True, default=0.0
    )
    frequency: Float[Array, ""] | float = parameter(
        "Hz", "frequency of the mains", lower=45.0, upper=65.0, tries=(50.0, 60.0), default=50.0
    )
    second_even: Float[Array, ""] | float = _harmonic(
        "hum at twice the frequency over that at it, part that is greatest when that is greatest or least"
    )
    second_odd: Float[Array, ""] | float = _harmonic(
        "the same, part that is greatest an eighth of a period of the mains later"
    )
    third_even: Float[Array, ""] | float = _harmonic(
        "hum at three times the frequency over that at it, part that is greatest when that is"
    )
    third_odd: Float[Array, ""] | float = _harmonic(
        "the same, part that is greatest a twelfth of a period of the mains later"
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        humming = _HummingForce(
            oscillator.instrument,
            self.cosine,
            self.sine,
            self.frequency,
            (self.second_even, self.second_odd),
            (self.third_even, self.third_odd),
        )
        return dataclasses.replace(oscillator, instrument=humming)


class _HummingForce(AbstractForceLink):
    inner: AbstractInstrument
    cosine: Scalar
    sine: Scalar
    frequency: Scalar
    second: tuple[Scalar, Scalar]
    third: tuple[Scalar, Scalar]

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        angle = 2 * jnp.pi * self.frequency * motion.t
        first = self.cosine * jnp.cos(angle) + self.sine * jnp.sin(angle)
        later = self.cosine * jnp.sin(angle) - self.sine * jnp.cos(angle)
        size = jnp.sqrt(self.cosine**2 + self.sine**2 + SILENT**2)
        second = (first**2 - later**2) / size, 2 * first * later / size
        third = first * (first**2 - 3 * later**2) / size**2, later * (3 * first**2 - later**2) / size**2
        harmonics = zip((*self.second, *self.third), (*second, *third), strict=True)
        return friction + first + sum(share * wave for share, wave in harmonics)
