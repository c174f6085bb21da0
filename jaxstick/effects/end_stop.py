"""Elastic stops that the mass meets near the ends of its stroke."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.added_force import AbstractAddedForce
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class EndStop(AbstractEffect):
    """Adds -stiffness (x - gap) beyond x = gap and -stiffness (x + below gap) beyond x = -below gap.

    With `below` well above 1 or well below it the stroke meets one stop alone.
    """

    card: ClassVar[Card] = Card(
        title="The mass meets elastic stops",
        family="mechanics",
        symptom=(
            "The balance of forces is clean in the middle and has an extra restoring force beyond a certain "
            "displacement; large strokes are cut short, small ones not changed at all."
        ),
        explanation=(
            "Near the end of the stroke something else begins to push back: a buffer, a cable, a spring "
            "whose coils touch, the edge of the slide. It is there only in runs whose amplitude reaches it."
        ),
        remedy=(
            "Look for marks of contact; push the slider through the whole stroke by hand. Move the stops "
            "outwards or shorten the stroke."
        ),
        source=(
            "Shaw, Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983) 129."
        ),
    )
    stiffness: Float[Array, ""] | float = parameter(
        "N/m", "stiffness of the stops", lower=0.0, null=0.0, typical=1.0, default=0.0
    )
    gap: Float[Array, ""] | float = parameter(
        "m", "displacement at which a stop is met", lower=0.0, typical=0.7, span=(4.0, 20.0), default=5e-3
    )
    below: Float[Array, ""] | float = parameter(
        "1",
        "displacement at which the stop on the other side is met, over that",
        lower=0.05,
        upper=20.0,
        typical=1.0,
        default=1.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        stopped = _Stopped(oscillator.rig, self.stiffness, self.gap, self.below)
        return dataclasses.replace(oscillator, rig=stopped)


class _Stopped(AbstractAddedForce):
    inner: AbstractRig
    stiffness: Scalar
    gap: Scalar
    below: Scalar

    def added(self, memory: Any, motion: Motion) -> Scalar:
        return self.stiffness * (jnp.clip(motion.x, -self.below * self.gap, self.gap) - motion.x)
