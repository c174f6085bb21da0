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


class ForceClipping(AbstractEffect):
    """Of the force beyond `level` the share `cut` is lost; cut = 1 is an amplifier that clips at `level`."""

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

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(
            oscillator, instrument=_ClippedForce(oscillator.instrument, self.cut, self.level)
        )


class _ClippedForce(AbstractForceLink):
    inner: AbstractInstrument
    cut: Scalar
    level: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        return friction - self.cut * (friction - jnp.clip(friction, -self.level, self.level))
