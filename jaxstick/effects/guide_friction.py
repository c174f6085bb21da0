"""Dry friction on the mass that the force sensor does not see."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.added_force import AbstractAddedForce
from jaxstick.parts.decay import mean_decay
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class GuideFriction(AbstractEffect):
    """Adds -force s to the force on the mass, s between -1 and 1 the yield of an elastic guide.

    ds/dt = (dx/dt - creep s)/deflection, held at -1 and 1: Coulomb's friction through a spring of stiffness
    force/deflection, so that the guide sticks when the mass does, in series with a film of lubricant that
    creeps (Maxwell's element). Where nothing creeps the guide holds for ever; where it creeps fast, its force
    grows with the velocity up to `creep`. It acts against the ground and is no part of the recorded friction
    force.
    """

    card: ClassVar[Card] = Card(
        title="The guide rubs, unseen by the force sensor",
        family="mechanics",
        symptom=(
            "The balance of forces lacks a force of constant size that opposes the velocity, while the "
            "recorded friction force itself is as simulated; it is the same in slow and fast runs."
        ),
        explanation=(
            "The mass is held by more than the measured contact: bearings, seals, cables, the plunger of a "
            "displacement gauge. Their dry friction brakes the mass but does not pass through the force "
            "sensor."
        ),
        remedy=(
            "Lift the contact and let the mass swing freely: dry friction lets the amplitude fall by equal "
            "steps, 4 force/K a cycle. Replace or lubricate bearings, take touching sensors off. A guide "
            "that creeps is lubricated already."
        ),
        source=(
            "Den Hartog, Forced vibrations with combined Coulomb and viscous friction, Trans. ASME 53 "
            "(1931) 107."
        ),
    )
    force: Float[Array, ""] | float = parameter(
        "N", "dry friction of the guide", lower=0.0, null=0.0, typical=0.03, default=0.0
    )
    deflection: Float[Array, ""] | float = parameter(
        "m", "deflection at which the guide yields", lower=1e-9, typical=3e-3, default=3e-5
    )
    creep: Float[Array, ""] | float = parameter(
        "m/s",
        "velocity at which a lubricated guide creeps under its whole force",
        lower=0.0,
        typical=0.01,
        span=(1e4, 50.0),
        default=1e-9,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        rubbing = _Rubbing(oscillator.rig, self.force, 1 / self.deflection, self.creep / self.deflection)
        return dataclasses.replace(oscillator, rig=rubbing)


class _Yield(NamedTuple):
    """The share of its force that the guide exerts, -1 to 1, the displacement there [m] and the time [s]."""

    share: Scalar
    x: Scalar
    t: Scalar


class _Rubbing(AbstractAddedForce):
    """At the start the share is that of a mass which slides, or to which the contact has given way since. The
    velocity is taken for constant since the share was last known."""

    inner: AbstractRig
    strength: Scalar
    per_metre: Scalar
    per_second: Scalar

    def begin(self, motion: Motion) -> Any:
        share = motion.slid if motion.stick is None else motion.stick.yielded(self.per_metre)
        return _Yield(share, motion.x, motion.t)

    def carry(self, memory: _Yield, motion: Motion, step: Scalar) -> Any:
        return _Yield(self._share(memory, motion), motion.x, motion.t)

    def added(self, memory: _Yield, motion: Motion) -> Scalar:
        return -self.strength * self._share(memory, motion)

    def _share(self, memory: _Yield, motion: Motion) -> Scalar:
        crept = self.per_second * (motion.t - memory.t)
        arriving = self.per_metre * (motion.x - memory.x) * mean_decay(crept)
        share = jnp.exp(-crept) * memory.share + arriving
        return jnp.clip(share, -1.0, 1.0)
