"""A restoring force with a cubic term."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.added_force import AbstractAddedForce
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class CubicStiffness(AbstractEffect):
    """Adds -coefficient x^3 to the force on the mass: springs that stiffen (or soften, below 0) both ways."""

    card: ClassVar[Card] = Card(
        title="The springs stiffen with deflection",
        family="mechanics",
        symptom=(
            "The balance of forces leaves a third harmonic that depends on the place of the mass alone and "
            "grows with the cube of the stroke, the same at every frequency; resonance moves with "
            "amplitude."
        ),
        explanation=(
            "A spring is linear for small deflections only. Leaf springs, clamped strips and diaphragms "
            "stiffen as they stretch; springs near buckling, magnets and pendulums soften."
        ),
        remedy=(
            "Record force over displacement statically over the whole stroke. Shorten the stroke, or give "
            "the simulator the measured characteristic."
        ),
        source="Nayfeh, Mook, Nonlinear Oscillations, Wiley, New York 1979.",
    )
    coefficient: Float[Array, ""] | float = parameter(
        "N/m^3", "cubic stiffness", null=0.0, typical=0.15, default=0.0
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, rig=_Cubic(oscillator.rig, self.coefficient))


class _Cubic(AbstractAddedForce):
    inner: AbstractRig
    coefficient: Scalar

    def added(self, memory: Any, motion: Motion) -> Scalar:
        return -self.coefficient * (motion.x * motion.x * motion.x)
