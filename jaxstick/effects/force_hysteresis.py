"""A force channel with play: it lags behind every reversal of the force, however slow."""

from __future__ import annotations

import dataclasses
from typing import ClassVar, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument, Past
from jaxstick.parts.motion import Motion, Scalar

APART = -0.8, -0.4, 0.0, 0.4, 0.8
"""Half widths of the plays beyond their mean, in units of the spread."""


class ForceHysteresis(AbstractEffect):
    """The recorded force p follows F with play: it stands still while |F - p| < width, else it is dragged.

    With a `spread` it is the mean of several plays side by side, whose half widths lie evenly between
    (1 - spread) width and (1 + spread) width: loops then are round at their corners, and small ones thinner.
    """

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
        source="A. Visintin, Differential Models of Hysteresis, Springer 1994 (the play operator, and "
        "Prandtl's and Ishlinskii's many of them).",
    )
    width: Float[Array, ""] | float = parameter(
        "N", "half the width of the play", lower=0.0, null=0.0, typical=0.015, default=0.0
    )
    spread: Float[Array, ""] | float = part_of_it("by how much of it the plays of several joints differ")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        instrument = _PlaysInForce(oscillator.instrument, self.width, self.spread)
        return dataclasses.replace(oscillator, instrument=instrument)


class _Plays(NamedTuple):
    """By how much the entering force is ahead of what every play lets through [N], and the entering force
    [N]."""

    lead: Array
    entering: Scalar


class _PlaysInForce(AbstractForceLink):
    """At the start the plays lie where the recorded force says, each as far off its middle for its width,
    else on the side on which the rate of the force then has put them."""

    inner: AbstractInstrument
    width: Scalar
    spread: Scalar

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> _Plays:
        ahead = jnp.asarray(friction - past.before.recorded)
        lead = jnp.where(jnp.isnan(ahead), self.width * jnp.sign(past.rate), _within(ahead, self.width))
        return _Plays(self._parts() * lead, friction)

    def follow(self, own: _Plays, motion: Motion, friction: Scalar, step: Scalar) -> _Plays:
        lead = own.lead + (friction - own.entering)
        return _Plays(_within(lead, self.width * self._parts()), friction)

    def passed(self, own: _Plays, motion: Motion, friction: Scalar) -> Scalar:
        return friction - own.lead.mean()

    def _parts(self) -> Array:
        return 1.0 + self.spread * jnp.asarray(APART)


def _within(lead: Array, width: Scalar) -> Array:
    return jnp.where(lead > width, width, jnp.where(lead < -width, -width, lead))
