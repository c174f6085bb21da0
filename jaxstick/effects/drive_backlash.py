"""Play in the joint through which the base drives the mass."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.drive import Excitation
from jaxstick.parts.guide import Surface
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class DriveBacklash(AbstractEffect):
    """The drive spring and damper see the base through play: the joint follows y only when it is `gap` off.

        held = min(max(held, y - gap), y + gap),    carried = min(max(x, y - gap), y + gap)
        joint = (1 - floating) held + floating carried

    A joint that its own friction holds is at rest while the gap is crossed (the play operator). One that
    nothing holds goes with the mass there, so that its spring is slack (a dead zone). The surface under the
    mass, should it be carried by the base, has no play.
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
    floating: Float[Array, ""] | float = part_of_it("share in which nothing holds the joint in its gap")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, rig=_Loose(oscillator.rig, self.gap, self.floating))


class _Loose(AbstractRig):
    """State: that of `inner`, the place of the joint were it held [m].

    It starts from where the recorded base has taken it, and that from where a steady drive leaves it; this
    one alone where no motion was recorded.
    """

    inner: AbstractRig
    gap: Scalar
    floating: Scalar

    def initial(self, motion: Motion) -> Any:
        return self.inner.initial(motion), motion.y + self._ahead(motion)

    def _ahead(self, motion: Motion) -> Scalar:
        """How far the joint is ahead of the base at the start [m]."""
        if motion.track is None:
            return -self.gap * jnp.sign(motion.y_rate)
        base = motion.track.drive
        y, rate = base.oldest()
        return base.played(self.gap, y - self.gap * jnp.sign(rate)) - base.values[0]

    def advance(self, state: Any, motion: Motion, step: Scalar) -> Any:
        inner, joint = state
        held, _ = self._within(joint, 0.0, motion)
        return self.inner.advance(inner, self._behind(joint, motion), step), held

    def surface(self, excitation: Excitation) -> Surface:
        return self.inner.surface(excitation)

    def inertia(self) -> Scalar:
        return self.inner.inertia()

    def force(self, state: Any, motion: Motion) -> Scalar:
        inner, joint = state
        return self.inner.force(inner, self._behind(joint, motion))

    def _behind(self, joint: Scalar, motion: Motion) -> Motion:
        """The motion with the base as it is behind the joint."""
        held, carried = self._within(joint, 0.0, motion), self._within(motion.x, motion.v, motion)
        y, y_rate = (
            (1 - self.floating) * one + self.floating * other
            for one, other in zip(held, carried, strict=True)
        )
        return motion._replace(y=y, y_rate=y_rate)

    def _within(self, place: Scalar, rate: Scalar, motion: Motion) -> tuple[Scalar, Scalar]:
        """A place and its rate, or those of the end of the gap that takes it along."""
        low, high = motion.y - self.gap, motion.y + self.gap
        pushed, pulled = place <= low, place >= high
        within = jnp.where(pushed, low, jnp.where(pulled, high, place))
        return within, jnp.where(pushed | pulled, motion.y_rate, rate)
