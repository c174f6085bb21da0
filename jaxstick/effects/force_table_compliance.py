"""A force table that rings at its own natural frequency."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument, Past
from jaxstick.parts.lag import Lag, followed, lagged, settled
from jaxstick.parts.motion import Motion, Scalar

LEAST_LEFT = 0.02
"""No less of the force than this share is taken to be recorded at once before a start."""


class ForceTableCompliance(AbstractEffect):
    """The share `share` of the force reaches the gauges through a table on springs, the rest at once.

        f = F + share (r - F),   r'' + 2 damping w r' + w^2 r = w^2 F,   w = 2 pi frequency

    A table with two modes answers with (1 - second) r + second r2, r2 being what a mode with the same damping
    ratio and `ratio` times the natural frequency answers.
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
    second: Float[Array, ""] | float = part_of_it("share of what the table passes that its second mode does")
    ratio: Float[Array, ""] | float = parameter(
        "1",
        "natural frequency of the second mode over that of the first",
        lower=1.3,
        upper=10.0,
        typical=2.5,
        default=2.5,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        radian = 1 / (2 * jnp.pi * self.frequency * jnp.array([1.0, self.ratio]))
        weights = jnp.array([1 - self.second, self.second])
        ringing = _RingingForce(oscillator.instrument, self.share, radian, self.damping, weights)
        return dataclasses.replace(oscillator, instrument=ringing)


class _RingingForce(AbstractForceLink):
    """`radian`: the times in which the modes turn by one radian [s]; `weights`: their shares.

    Where the force channel is known before the start, a mode rings there as that has made it ring: of what it
    showed, f = (1 - s) F + s r, the mode has its share s of `share`, whence

        r'' + 2 damping w r' + w^2/(1 - s) r = w^2/(1 - s) f,

    the other mode taken to follow the force at once.
    """

    inner: AbstractInstrument
    share: Scalar
    radian: Array
    damping: Scalar
    weights: Array

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> Lag:
        still = settled(friction, 2 * self.damping * past.change(friction, self.radian))
        if past.before.shown is None:
            return still
        left = jnp.maximum(1 - self.share * self.weights, LEAST_LEFT)
        time, curvature = 2 * self.damping * self.radian * left, 1 / (4 * self.damping**2 * left)
        rung = jax.vmap(followed, (None, 0, 0))(past.before.shown, time, curvature)
        unknown = jnp.isnan(past.before.recorded)
        return Lag(
            jnp.where(unknown, still.level, rung.level),
            jnp.where(unknown, still.swing, rung.swing / left),
            still.entering,
        )

    def follow(self, own: Lag, motion: Motion, friction: Scalar, step: Scalar) -> Lag:
        time = 2 * self.damping * self.radian
        return lagged(own, friction, step, time, 1 / (4 * self.damping**2))

    def passed(self, own: Lag, motion: Motion, friction: Scalar) -> Scalar:
        return friction + self.share * (jnp.sum(self.weights * own.level) - friction)
