"""A force table that rings at its own natural frequency."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument, Past
from jaxstick.parts.lag import Lag, lagged, settled
from jaxstick.parts.motion import Motion, Scalar


class ForceTableCompliance(AbstractEffect):
    """The share `share` of the force reaches the gauges through a table on springs, the rest at once.

        f = F + share (r - F),   r'' + 2 damping w r' + w^2 r = w^2 F,   w = 2 pi frequency

    A rigid table (w without end) would be a null value too, but next to it the table's answer to an edge of F
    is 1/w^2 times a spike, of no use as a first-order forecast of a ring; the share makes one for the
    frequency at hand. A table that carries the whole contact has share 1.
    """

    card: ClassVar[Card] = Card(
        title="Force table resonates",
        family="measurement",
        symptom="After breakaway, arrest and reversal the recorded force overshoots and rings at a frequency "
        "of its own, the same in every run and in stick and slip alike; the displacement does not ring.",
        explanation=(
            "The guide stands on a table with mass and cantilever springs, and what is recorded is the force "
            "in the springs. Below the table's natural frequency that is the friction force, slightly too "
            "large; every edge of the friction makes the table ring. A ring of the contact itself depends on "
            "k1 and the moving mass, is there in stick only, and is in the displacement too."
        ),
        remedy="Tap the table with the slider in place and read frequency and decay off the force channel; "
        "stiffen or lighten the table, or correct the record by the inverse of its response.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "second-order instruments; J. P. Den Hartog, Mechanical Vibrations, 4th ed., McGraw-Hill 1956.",
    )
    share: Float[Array, ""] | float = parameter(
        "1",
        "share of the force that goes through the table's springs",
        lower=0.0,
        upper=2.0,
        null=0.0,
        typical=1.0,
        default=0.0,
    )
    frequency: Float[Array, ""] | float = parameter(
        "Hz", "natural frequency of the table", lower=5.0, upper=2000.0, typical=10.0, default=46.0
    )
    damping: Float[Array, ""] | float = parameter(
        "1", "damping ratio of the table", lower=0.005, upper=0.5, typical=0.05, default=0.05
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(
            oscillator,
            instrument=_RingingForce(oscillator.instrument, self.share, self.frequency, self.damping),
        )


class _RingingForce(AbstractForceLink):
    inner: AbstractInstrument
    share: Scalar
    frequency: Scalar
    damping: Scalar

    def _radian(self) -> Scalar:
        """The time in which the table turns by one radian [s]."""
        return 1 / (2 * jnp.pi * self.frequency)

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> Lag:
        change = past.change(friction, self._radian())
        return settled(friction, 2 * self.damping * change)

    def follow(self, own: Lag, motion: Motion, friction: Scalar, step: Scalar) -> Lag:
        time = 2 * self.damping * self._radian()
        return lagged(own, friction, step, time, 1 / (4 * self.damping**2))

    def passed(self, own: Lag, motion: Motion, friction: Scalar) -> Scalar:
        return friction + self.share * (own.level - friction)
