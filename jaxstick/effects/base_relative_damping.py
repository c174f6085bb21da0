"""Damping that acts between mass and base."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.added_force import AbstractAddedForce
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class BaseRelativeDamping(AbstractEffect):
    """Adds damping (y' - braking v) to the force on the mass.

    Where braking is 0, so much more of its total damping joins the mass to the base, and none to the ground;
    where it is 1, a damper between mass and base has been forgotten altogether.
    """

    card: ClassVar[Card] = Card(
        title="Damping acts between mass and base",
        family="mechanics",
        symptom=(
            "The balance of forces lacks a force in phase with the base's velocity, which grows with "
            "frequency; the mass lags the base less than simulated."
        ),
        explanation=(
            "The damping was measured on the free mass with the base at rest, which does not tell whether "
            "the damper stands on the ground or on the moving base. On the base it drives the mass as well "
            "as brakes it. A base record that is late by damping/k_d looks exactly the same."
        ),
        remedy=(
            "Find out by construction where the damping arises (the drive spring, the joint, the air). "
            "Check the timing of the base channel with a pulse common to all channels."
        ),
        source=(
            "Hundal, Response of a base excited system with Coulomb and viscous friction, J. Sound Vib. 64 "
            "(1979) 371."
        ),
    )
    traces: ClassVar[tuple[str, ...]] = ("timing of the base",)
    damping: Float[Array, ""] | float = parameter(
        "N s/m", "damping between mass and base beyond what is stated", null=0.0, typical=0.01, default=0.0
    )
    braking: Float[Array, ""] | float = part_of_it(
        "share of it that is not in the stated damping of the mass"
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, rig=_Coupled(oscillator.rig, self.damping, self.braking))


class _Coupled(AbstractAddedForce):
    inner: AbstractRig
    damping: Scalar
    braking: Scalar

    def added(self, memory: Any, motion: Motion) -> Scalar:
        return self.damping * (motion.y_rate - self.braking * motion.v)
