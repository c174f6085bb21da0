"""A force channel that does not pass constant forces."""

from __future__ import annotations

import dataclasses
from typing import ClassVar, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument, Past
from jaxstick.parts.motion import Motion, Scalar


class ForceHighpass(AbstractEffect):
    """A high-pass of first order: f = F - before - w (integral of f since the run began), w = 2 pi corner.

    In the middle of a record the integral is that of the recorded force, `Start.impulse`.
    """

    card: ClassVar[Card] = Card(
        title="Force channel is coupled for alternating forces only",
        family="measurement",
        symptom="The plateaus of the recorded force sag towards zero while the sliding lasts, most in the "
        "slowest run; a force held in stick dies away, and after a reversal the force overshoots.",
        explanation=(
            "The channel blocks constant signals: an analyser input set to AC, a piezoelectric force sensor "
            "whose charge leaks away, an amplifier with a coupling capacitor. Everything that lasts longer "
            "than 1/(2 pi corner) seconds is lost. In a slow run that looks like friction that falls with "
            "the time or the length of the slip."
        ),
        remedy="Set the input to DC; with a piezoelectric sensor choose the long time constant and set it to "
        "zero just before the run; hang a weight on the table and watch whether the reading stays.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "piezoelectric transducers and the time constant of the charge amplifier.",
    )
    changes: ClassVar[bool] = True
    corner: Float[Array, ""] | float = parameter(
        "Hz", "corner frequency", lower=0.0, upper=5.0, null=0.0, typical=0.005, default=0.0
    )
    before: Float[Array, ""] | float = parameter(
        "N",
        "what the channel had lost when the run began, having been switched on before",
        null=0.0,
        typical=0.01,
        by_run=True,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(
            oscillator,
            instrument=_LeakingForce(oscillator.instrument, 2 * jnp.pi * self.corner, self.before),
        )


class _Leak(NamedTuple):
    """What of the entering force has been lost [N], and the entering force [N]."""

    lost: Scalar
    entering: Scalar


class _LeakingForce(AbstractForceLink):
    """lost' = leak (F - lost), by the trapezoidal rule."""

    inner: AbstractInstrument
    leak: Scalar
    before: Scalar

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> _Leak:
        return _Leak(self.before + self.leak * past.impulse, friction)

    def follow(self, own: _Leak, motion: Motion, friction: Scalar, step: Scalar) -> _Leak:
        half = self.leak * step / 2
        return _Leak(((1 - half) * own.lost + half * (own.entering + friction)) / (1 + half), friction)

    def passed(self, own: _Leak, motion: Motion, friction: Scalar) -> Scalar:
        return friction - own.lost
