"""A constant force on the mass: a tilted rig, a preloaded spring, an offset of the drive's force."""

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


class ConstantForce(AbstractEffect):
    """Adds `force` [N] to the equation of motion; on a sprung rig it moves the rest position by force/K."""

    card: ClassVar[Card] = Card(
        title="Constant force",
        family="mechanics",
        symptom="The displacement is offset; stops lie nearer to one end of the stroke than to the other.",
        explanation=(
            "A force that never changes acts along the guide: the rig is not level, a spring is preloaded, "
            "or the zero of the displacement or of the drive's force is not where the simulator puts it."
        ),
        remedy="Level the rig; turn it by 180 degrees and repeat; record the zero of each sensor at rest.",
        source="Equation of motion; an offset of the displacement by force/K is the same thing.",
    )
    force: Float[Array, ""] | float = parameter(
        "N", "constant force on the mass", null=0.0, typical=0.05, default=0.0
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, rig=_LoadedRig(oscillator.rig, self.force))


class _LoadedRig(AbstractAddedForce):
    inner: AbstractRig
    load: Scalar

    def added(self, memory: Any, motion: Motion) -> Scalar:
        return self.load
