"""Springs or a mass that are not as stated."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.drive import Excitation
from jaxstick.parts.guide import Surface
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class StiffnessError(AbstractEffect):
    """Adds stiffness (y - x) - ground_stiffness x to the force on the mass, and `mass` to its inertia."""

    card: ClassVar[Card] = Card(
        title="Stiffness or mass is not as stated",
        family="mechanics",
        symptom=(
            "The balance of forces is off by a share of the spring force or of the inertia force, at every "
            "amplitude and in every run alike; the natural frequency is not the simulated one."
        ),
        explanation=(
            "The number in rig.toml is wrong: a spring from the catalogue, a clamp that gives, a third of "
            "the spring's own mass that moves along, a mount weighed without its screws. An error in the "
            "gain of the force sensor looks like one of mass and stiffness together."
        ),
        remedy=(
            "Weigh everything that moves, with a third of the springs. Measure the stiffness with dead "
            "weights, or the free frequency with and without a known added mass."
        ),
        source="Rayleigh, The Theory of Sound, vol. 1, Macmillan, London 1894 (effective mass of a spring).",
    )
    traces: ClassVar[tuple[str, ...]] = ("scale of the forces", "scale of the drive")
    traces_in_motion: ClassVar[tuple[str, ...]] = ("scale of the drive",)
    stiffness: Float[Array, ""] | float = parameter(
        "N/m", "stiffness between mass and base beyond what is stated", null=0.0, typical=0.06, default=0.0
    )
    ground_stiffness: Float[Array, ""] | float = parameter(
        "N/m", "stiffness between mass and ground beyond what is stated", null=0.0, typical=0.06, default=0.0
    )
    mass: Float[Array, ""] | float = parameter(
        "kg", "moving mass beyond what is stated", null=0.0, typical=1.5e-3, default=0.0
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        misstated = _Misstated(oscillator.rig, self.stiffness, self.ground_stiffness, self.mass)
        return dataclasses.replace(oscillator, rig=misstated)


class _Misstated(AbstractRig):
    inner: AbstractRig
    stiffness: Scalar
    ground_stiffness: Scalar
    mass: Scalar

    def initial(self, motion: Motion) -> Any:
        return self.inner.initial(motion)

    def advance(self, state: Any, motion: Motion, step: Scalar) -> Any:
        return self.inner.advance(state, motion, step)

    def surface(self, excitation: Excitation) -> Surface:
        return self.inner.surface(excitation)

    def inertia(self) -> Scalar:
        return self.inner.inertia() + self.mass

    def force(self, state: Any, motion: Motion) -> Scalar:
        more = self.stiffness * (motion.y - motion.x) - self.ground_stiffness * motion.x
        return self.inner.force(state, motion) + more
