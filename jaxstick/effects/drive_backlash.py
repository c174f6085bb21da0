"""Play in the joint through which the base drives the mass."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.drive import Excitation
from jaxstick.parts.guide import Surface
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class DriveBacklash(AbstractEffect):
    """The drive spring and damper see the base through play: the joint follows y only when it is `gap` off.

    The play operator: joint <- min(max(joint, y - gap), y + gap). The joint is at rest while the gap is
    crossed. The surface under the mass, should it be carried by the base, has no play.
    """

    card: ClassVar[Card] = Card(
        title="The drive has play",
        family="mechanics",
        symptom=(
            "The balance of forces lacks a force of constant size that changes sign whenever the base turns "
            "back, whatever the mass does; just after it turns, the drive spring is not loaded further."
        ),
        explanation=(
            "A joint between the base and its spring is loose: a pin in its hole, a thread, a gear, a "
            "crank. When the base turns back it crosses the gap before it takes the spring along."
        ),
        remedy=(
            "Hold the mass and move the base to and fro by a tenth of a millimetre while reading the spring "
            "force. Preload the joint; record the base at the spring's end of it."
        ),
        source=(
            "Nordin, Gutman, Controlling mechanical systems with backlash, a survey, Automatica 38 (2002) "
            "1633."
        ),
    )
    gap: Float[Array, ""] | float = parameter(
        "m", "play to either side of the middle", lower=0.0, null=0.0, typical=5e-3, default=0.0
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, rig=_Loose(oscillator.rig, self.gap))


class _Loose(AbstractRig):
    """State: that of `inner`, the place of the joint [m], at first where a steady drive leaves it."""

    inner: AbstractRig
    gap: Scalar

    def initial(self, motion: Motion) -> Any:
        joint = motion.y - self.gap * jnp.sign(motion.y_rate)
        return self.inner.initial(motion), joint

    def advance(self, state: Any, motion: Motion, step: Scalar) -> Any:
        inner, joint = state
        after = self._behind(joint, motion)
        return self.inner.advance(inner, after, step), after.y

    def surface(self, excitation: Excitation) -> Surface:
        return self.inner.surface(excitation)

    def inertia(self) -> Scalar:
        return self.inner.inertia()

    def force(self, state: Any, motion: Motion) -> Scalar:
        inner, joint = state
        return self.inner.force(inner, self._behind(joint, motion))

    def _behind(self, joint: Scalar, motion: Motion) -> Motion:
        """The motion with the base as it is behind the joint."""
        low, high = motion.y - self.gap, motion.y + self.gap
        pushed, pulled = joint <= low, joint >= high
        place = jnp.where(pushed, low, jnp.where(pulled, high, joint))
        return motion._replace(y=place, y_rate=jnp.where(pushed | pulled, motion.y_rate, 0.0))
