"""Drag that grows with the square of the velocity."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.added_force import AbstractAddedForce
from jaxstick.parts.bend import bend_of, bent
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class QuadraticDrag(AbstractEffect):
    """Adds -coefficient v |v| (1 + bend |v|) to the force: without a bend 8/3 coefficient w^2 X^3 of work in
    a cycle of X sin w t."""

    card: ClassVar[Card] = Card(
        title="Drag grows with the square of the speed",
        family="mechanics",
        symptom=(
            "The balance of forces lacks a force against the velocity that matters near resonance and not "
            "in slow runs; the damping seems to grow with amplitude."
        ),
        explanation=(
            "Air or oil that is pushed aside resists with the square of the speed: a plate on the slider, a "
            "piston in its bore, a rig in a bath; where the flow changes with the speed, so does the power "
            "(bend). A viscous damper fitted at one speed is then wrong at others."
        ),
        remedy=(
            "Let the mass swing freely without contact from a large and from a small amplitude: the "
            "decrement grows with amplitude. Take away what catches the air."
        ),
        source="Jacobsen, Steady forced vibration as influenced by damping, Trans. ASME 52 (1930) 169.",
    )
    coefficient: Float[Array, ""] | float = parameter(
        "N s^2/m^2", "drag over squared speed", lower=0.0, null=0.0, typical=1e-3, default=0.0
    )
    bend: Float[Array, ""] | float = bend_of("s/m", "speed")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, rig=_Dragged(oscillator.rig, self.coefficient, self.bend))


class _Dragged(AbstractAddedForce):
    inner: AbstractRig
    coefficient: Scalar
    bend: Scalar

    def added(self, memory: Any, motion: Motion) -> Scalar:
        return -self.coefficient * bent(motion.v, self.bend) * jnp.abs(motion.v)
