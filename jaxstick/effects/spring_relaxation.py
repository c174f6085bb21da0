"""A spring that relaxes: a Maxwell branch beside the elastic ones."""

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


class SpringRelaxation(AbstractEffect):
    """Adds -stiffness (x - w) to the force on the mass, with time w' = x - w: spring and damper in series.

    At angular frequency o the branch has the complex stiffness `stiffness` i o time/(1 + i o time): none when
    slow, `stiffness` when fast, and the loss is greatest at o time = 1.
    """

    card: ClassVar[Card] = Card(
        title="The springs relax",
        family="mechanics",
        symptom=(
            "In stops, and after each fast move, the force needed to hold the mass fades; the springs are "
            "stiffer in fast runs than in slow ones and lose most energy in between."
        ),
        explanation=(
            "Rubber, glue, plastic or clamped joints in the path of the spring force creep under load and "
            "catch up with the motion after a time of their own. A viscous damper, which loses the more the "
            "faster the motion, cannot stand for that."
        ),
        remedy=(
            "Deflect the spring by a step and record its force: it decays to the static value with the "
            "relaxation time. Replace elastomers and clamped joints by metal and screws."
        ),
        source="Zener, Elasticity and Anelasticity of Metals, University of Chicago Press 1948.",
    )
    stiffness: Float[Array, ""] | float = parameter(
        "N/m", "stiffness of the relaxing branch", lower=0.0, null=0.0, typical=0.1, default=0.0
    )
    time: Float[Array, ""] | float = parameter("s", "relaxation time", lower=1e-6, typical=0.5, default=0.1)

    def attach(self, oscillator: Oscillator) -> Oscillator:
        extent = oscillator.drive.extent()
        still = jnp.asarray(extent.y) == 0
        rhythm = jnp.where(still, 0.0, extent.y_rate / jnp.where(still, 1.0, extent.y))
        return dataclasses.replace(
            oscillator, rig=_Relaxing(oscillator.rig, self.stiffness, self.time, rhythm)
        )


class _Relaxing(AbstractAddedForce):
    """Memory: w at the coming node [m], by the trapezoidal rule from the motion at the last one.

    It starts from where the recorded motion has brought it, and that from where a harmonic motion at the
    drive's angular frequency `rhythm` would have; this one alone where no motion was recorded.
    """

    inner: AbstractRig
    stiffness: Scalar
    time: Scalar
    rhythm: Scalar

    def begin(self, motion: Motion) -> Any:
        if motion.track is None:
            return self._in_rhythm(motion.x, motion.v)
        return motion.track.mass.followed(self.time, self._in_rhythm(*motion.track.mass.oldest()))

    def _in_rhythm(self, x: Scalar, v: Scalar) -> Scalar:
        """Where w is in a harmonic motion."""
        return (x - self.time * v) / (1 + (self.rhythm * self.time) ** 2)

    def carry(self, memory: Scalar, motion: Motion, step: Scalar) -> Any:
        half = step / (2 * self.time)
        middle = motion.x + step / 2 * motion.v
        return (memory * (1 - half) + 2 * half * middle) / (1 + half)

    def added(self, memory: Scalar, motion: Motion) -> Scalar:
        return -self.stiffness * (motion.x - memory)
