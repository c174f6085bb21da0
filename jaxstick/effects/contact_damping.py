"""A damper beside the contact spring."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.contact import AbstractContact, Approach, Grip, Passage, Traction, sense_of
from jaxstick.parts.motion import Scalar


class ContactDamping(AbstractEffect):
    """Adds -damping (1 - loading + 2 loading |F|/F_s) v to the friction force while the contact sticks.

    F is the force on the contact, F_s the limit at rest. Where `loading` is 0 the damping is sigma_1 of the
    LuGre model; where it is 1, asperities without load lose nothing (Hunt, Crossley, J. Applied Mechanics 42
    (1975) 440). On average over a loading from 0 to F_s it is `damping` in any case. The force is taken at
    the velocity that the mass has under it, so that no damping is too much for a step.
    """

    card: ClassVar[Card] = Card(
        title="The contact is damped in stick",
        family="friction",
        symptom=(
            "After the mass is caught, the friction force rings for fewer cycles than simulated, or not at "
            "all; the damped ring is that of the mass on the contact spring."
        ),
        explanation=(
            "The asperities, or the glue and the film between the surfaces, lose energy when they are "
            "sheared to and fro without slipping. The simulator has a spring there that loses none, so its "
            "stops ring on."
        ),
        remedy=(
            "Tap the slider at rest and record the decay of its small oscillation: its logarithmic "
            "decrement gives sigma_1. Then give the contact a damper."
        ),
        source=(
            "Canudas de Wit, Olsson, Astrom, Lischinsky, A new model for control of systems with friction, "
            "IEEE Trans. Automatic Control 40 (1995) 419."
        ),
    )
    damping: Float[Array, ""] | float = parameter(
        "N s/m", "damping of the contact in stick", lower=0.0, null=0.0, typical=0.3, default=0.0
    )
    loading: Float[Array, ""] | float = parameter(
        "1",
        "share of the damping that grows with the load on the contact",
        lower=0.0,
        upper=1.0,
        typical=0.1,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        contact = oscillator.contact
        return dataclasses.replace(
            oscillator, contact=_Damped(contact.k1, contact, self.damping, self.loading)
        )


class _Damped(AbstractContact):
    k1: Scalar
    inner: AbstractContact
    damping: Scalar
    loading: Scalar

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        return self.inner.initial(approach, traction)

    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        grip = self.inner.grip(state, passage, traction)
        limit = traction.limit(0.0, sense_of(-grip.mean))
        load = jnp.where(limit > 0, jnp.abs(grip.mean) / jnp.where(limit > 0, limit, 1.0), 0.0)
        loaded = 1 + self.loading * (2 * load - 1)
        stuck = self.damping * loaded * (1 - grip.slip)
        half = passage.step / (2 * grip.inertia_factor)
        coasting = passage.slide / passage.step + half * (passage.acceleration + grip.mean / passage.inertia)
        force = stuck * coasting / (1 + half / passage.inertia * stuck)
        return grip._replace(friction=grip.friction - force, mean=grip.mean - force)
