"""A restoring force with a quadratic term."""

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

FAR = 1e3
"""No spring is deflected so far [m]: its stiffness changes in proportion to the deflection."""


class QuadraticStiffness(AbstractEffect):
    """Adds -coefficient x^2/(1 + |x|/length) to the force on the mass: stiffer on one side of its rest.

    Far beyond `length` either side has a stiffness of its own, as where two different springs meet; the
    longer it is, the further the stiffness goes on changing in proportion to the deflection.
    """

    card: ClassVar[Card] = Card(
        title="The springs are stiffer on one side",
        family="mechanics",
        symptom=(
            "The balance of forces leaves an offset and a second harmonic that depend on the place of the "
            "mass alone and grow with the square of the stroke; the two halves of the motion differ."
        ),
        explanation=(
            "A spring that is bent, preloaded or not mounted in its middle pulls harder one way than the "
            "other: coil springs that begin to touch, leaf springs with a curve, two different springs on "
            "the two sides."
        ),
        remedy=(
            "Record force over displacement statically on both sides. Mount the springs in their middle and "
            "in equal pairs."
        ),
        source="Nayfeh, Mook, Nonlinear Oscillations, Wiley, New York 1979.",
    )
    coefficient: Float[Array, ""] | float = parameter(
        "N/m^2", "quadratic stiffness", null=0.0, typical=0.15, default=0.0
    )
    length: Float[Array, ""] | float = parameter(
        "m",
        "deflection from which the stiffness of either side levels off",
        lower=1e-9,
        upper=FAR,
        typical=2.0,
        default=FAR,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, rig=_Quadratic(oscillator.rig, self.coefficient, self.length))


class _Quadratic(AbstractAddedForce):
    inner: AbstractRig
    coefficient: Scalar
    length: Scalar

    def added(self, memory: Any, motion: Motion) -> Scalar:
        return -self.coefficient * (motion.x * motion.x) / (1.0 + jnp.abs(motion.x) / self.length)
