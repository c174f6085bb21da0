"""Friction that differs between the two directions of sliding."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.friction import AbstractFriction, AbstractWrappedFriction
from jaxstick.parts.motion import Motion, Scalar


class AsymmetricFriction(AbstractEffect):
    """Multiplies the dry part of the law by 1 + dry s and the viscous part by 1 + viscous s, s = sign(v).

    By the share `steady` what is added does not fall with the law's dry part as that weakens, but stays what
    it is at rest: with `steady` 1 the directions differ in C alone.
    """

    card: ClassVar[Card] = Card(
        title="Friction differs between the directions",
        family="friction",
        symptom=(
            "The plateaus of the friction force differ between forward and backward sliding, following the "
            "law's own dependence on speed."
        ),
        explanation=(
            "The surfaces or the guide resist more in one direction than in the other: worn asperities "
            "lean, a seal or a leaf spring is preloaded one way, a screw drive differs between pushing and "
            "pulling."
        ),
        remedy="Turn the slider by 180 degrees: the asymmetry turns with it if the surfaces cause it.",
        source="Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083.",
    )
    dry: Float[Array, ""] | float = parameter(
        "1", "relative difference of dry friction", lower=-0.9, upper=0.9, null=0.0, typical=0.05, default=0.0
    )
    viscous: Float[Array, ""] | float = parameter(
        "1",
        "relative difference of viscous friction",
        lower=-0.9,
        upper=0.9,
        null=0.0,
        typical=0.2,
        default=0.0,
    )
    steady: Float[Array, ""] | float = part_of_it(
        "share of the dry difference that stays as friction weakens"
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        friction = _DirectedFriction(oscillator.friction, self.dry, self.viscous, self.steady)
        return dataclasses.replace(oscillator, friction=friction)


class _DirectedFriction(AbstractWrappedFriction):
    inner: AbstractFriction
    dry: Scalar
    slope: Scalar
    steady: Scalar

    def limit(self, state: Any, motion: Motion) -> Scalar:
        limit = self.inner.limit(state, motion)
        static = self.inner.static(state, motion)
        return limit + self.dry * motion.direction * (limit + self.steady * (static - limit))

    def viscous(self, state: Any, motion: Motion) -> Scalar:
        return self.inner.viscous(state, motion) * (1 + self.slope * motion.direction)
