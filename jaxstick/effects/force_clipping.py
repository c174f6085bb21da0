"""A force channel that flattens high forces."""

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

HARD = 1e-9
"""A softness that is as good as none."""
LEAST = 1e-12
"""Share of the level below which a force is nothing."""


class ForceClipping(AbstractEffect):
    """Of what the force has beyond `level` the share `cut` is lost; cut = 1 is an amplifier that clips there.

    Clipped, a force F is F/(1 + |F/level|^(1/softness))^softness: with softness 0 F itself up to the level,
    which it then keeps; the larger that is, the earlier the force begins to flatten.
    """

    card: ClassVar[Card] = Card(
        title="Force channel clips its peaks",
        family="measurement",
        symptom="The peaks of the recorded force at breakaway are flattened, in both directions at the same "
        "level, while the motion shows that the force went on rising.",
        explanation=(
            "The force leaves the range in which amplifier, analogue-digital converter or gauges are linear: "
            "above a level they record less than there is, or nothing more at all. Static friction and the "
            "weakening A come out too small, and stops end later than the recorded force explains."
        ),
        remedy="Choose a wider range of the force channel, or a stiffer table; check with a weight of one "
        "and a half times the largest friction force.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "linearity and full scale; piecewise-linear saturation.",
    )
    cut: Float[Array, ""] | float = parameter(
        "1",
        "share lost of the force beyond the level",
        lower=0.0,
        upper=1.0,
        null=0.0,
        typical=0.5,
        default=0.0,
    )
    level: Float[Array, ""] | float = parameter(
        "N", "force up to which the channel is linear", lower=0.0, typical=0.9, span=(2.5, 2.5), default=6.0
    )
    softness: Float[Array, ""] | float = parameter(
        "1",
        "how early the force begins to flatten before the level",
        lower=0.0,
        upper=0.5,
        typical=0.25,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        instrument = _ClippedForce(oscillator.instrument, self.cut, self.level, self.softness)
        return dataclasses.replace(oscillator, instrument=instrument)


class _ClippedForce(AbstractForceLink):
    inner: AbstractInstrument
    cut: Scalar
    level: Scalar
    softness: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        softness = self.softness + HARD
        above = jnp.log(jnp.maximum(jnp.abs(friction), LEAST * self.level) / self.level)
        clipped = friction * jnp.exp(-softness * jnp.logaddexp(0.0, above / softness))
        return friction - self.cut * (friction - clipped)
