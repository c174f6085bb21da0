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


class MainsHum(AbstractEffect):
    """The force is recorded as F + a cos(p) + a second_even cos(2 p) + a second_odd sin(2 p).

    a cos(p) = cosine cos(2 pi frequency t) + sine sin(2 pi frequency t): p is the phase of the mains in the
    run, with which the second harmonic, that of rectifiers, keeps step in every run.
    It acts on the force channel: the millivolts of a strain gauge bridge pick up what the volts of a
    displacement transducer, demodulated from a carrier, do not.
    """

    card: ClassVar[Card] = Card(
        title="Mains hum on the force channel",
        family="measurement",
        symptom="The recorded force carries a line at 50 or 60 Hz, and perhaps at twice that, of the same "
        "height in stick and in slip and in every run, whatever the frequency of the excitation.",
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
    second_even: Float[Array, ""] | float = parameter(
        "1",
        "hum at twice the frequency over that at it, part that is greatest when that is greatest or least",
        lower=-1.0,
        upper=1.0,
        typical=0.2,
        default=0.0,
    )
    second_odd: Float[Array, ""] | float = parameter(
        "1",
        "the same, part that is greatest an eighth of a period of the mains later",
        lower=-1.0,
        upper=1.0,
        typical=0.2,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        humming = _HummingForce(
            oscillator.instrument,
            self.cosine,
            self.sine,
            self.frequency,
            self.second_even,
            self.second_odd,
        )
        return dataclasses.replace(oscillator, instrument=humming)


class _HummingForce(AbstractForceLink):
    inner: AbstractInstrument
    cosine: Scalar
    sine: Scalar
    frequency: Scalar
    even: Scalar
    odd: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        angle = 2 * jnp.pi * self.frequency * motion.t
        first = self.cosine * jnp.cos(angle) + self.sine * jnp.sin(angle)
        later = self.cosine * jnp.sin(angle) - self.sine * jnp.cos(angle)
        size = jnp.sqrt(self.cosine**2 + self.sine**2 + SILENT**2)
        return friction + first + (self.even * (first**2 - later**2) + 2 * self.odd * first * later) / size
