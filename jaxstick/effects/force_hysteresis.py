"""A force channel with play: it lags behind every reversal of the force, however slow."""

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


class ForceHysteresis(AbstractEffect):
    """The recorded force p follows F with play: it stands still while |F - p| < width, else it is dragged."""

    card: ClassVar[Card] = Card(
        title="Hysteresis of the force gauges",
        family="measurement",
        symptom="The recorded force trails by the same amount after every reversal, as far in the slowest "
        "run as in the fastest; around its peaks it stays flat for a while.",
        explanation=(
            "The elastic element, its clamping or the adhesive of the gauges gives back less on unloading "
            "than it took on loading: a joint of the table slips a little, a bolt is loose. Unlike a filter "
            "or a delay it asks for no time, only for a reversal, and its size does not grow with speed."
        ),
        remedy="Load and unload the table with weights in steps and plot the loop; tighten or weld the "
        "joints of the table; use an elastic element cut from one piece.",
        source="A. Visintin, Differential Models of Hysteresis, Springer 1994 (the play operator).",
    )
    width: Float[Array, ""] | float = parameter(
        "N", "half the width of the play", lower=0.0, null=0.0, typical=0.015, default=0.0
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, instrument=_PlayInForce(oscillator.instrument, self.width))


class _Play(NamedTuple):
    """By how much the entering force is ahead of the recorded one [N], and the entering force [N]."""

    lead: Scalar
    entering: Scalar


class _PlayInForce(AbstractForceLink):
    """At the start the play lies where the recorded force says, else on the side on which the rate of the
    force then has put it."""

    inner: AbstractInstrument
    width: Scalar

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> _Play:
        unknown = jnp.isnan(past.recorded)
        lead = self._within(friction - jnp.where(unknown, 0.0, past.recorded))
        return _Play(jnp.where(unknown, self.width * jnp.sign(past.rate), lead), friction)

    def follow(self, own: _Play, motion: Motion, friction: Scalar, step: Scalar) -> _Play:
        return _Play(self._within(own.lead + (friction - own.entering)), friction)

    def passed(self, own: _Play, motion: Motion, friction: Scalar) -> Scalar:
        return friction - own.lead

    def _within(self, lead: Scalar) -> Scalar:
        return jnp.where(lead > self.width, self.width, jnp.where(lead < -self.width, -self.width, lead))
