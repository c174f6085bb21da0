"""A contact of which a part yields before the whole slips."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.contact import (
    AbstractContact,
    Approach,
    Grip,
    Passage,
    Traction,
    fitted_inertia,
    sense_of,
)
from jaxstick.parts.motion import Scalar

LATEST = 0.8
"""What yields later than at this share of the limit is how the whole contact breaks away."""
BEFORE_AND_AFTER = -1.0, 0.0, 1.0
"""Which of the early elements yields before the middle one, and which after it."""


class Microslip(AbstractEffect):
    """Splits the contact into elements side by side, of which three yield early.

    Of the stiffness k1 these have `share`, a third each, and yield at the deflections earlier (1 - spread)
    g/k1, earlier g/k1 and earlier (1 + spread) g/k1, as one element without spread; the last element has the
    rest, and of the limit g what they leave. Initial stiffness and force in full slip stay as they are: k1
    and g.
    """

    card: ClassVar[Card] = Card(
        title="Part of the contact slips before the whole does",
        family="friction",
        symptom=(
            "In a stop the force over displacement is not the straight line of a spring: it bends before "
            "breakaway, and after a reversal it returns along another branch, so that stops cost energy."
        ),
        explanation=(
            "The contact is many asperities and the pressure is uneven: the lightly loaded ones slide while "
            "the rest still hold, all at once or one after another (spread). The contact creeps a little "
            "before it breaks away, and small oscillations in stick die down by friction, the larger the "
            "faster."
        ),
        remedy=(
            "Load the slider slowly to half its static friction and back, recording force and displacement "
            "to a micrometre: the area of the loop is the microslip. Press evenly, with flatter surfaces."
        ),
        source=(
            "Iwan, A distributed-element model for hysteresis and its steady-state dynamic response, J. "
            "Appl. Mech. 33 (1966) 893; Al-Bender, Lampaert, Swevers, IEEE Trans. Automatic Control 50 "
            "(2005) 1883."
        ),
    )
    share: Float[Array, ""] | float = parameter(
        "1",
        "share of the contact's stiffness that yields early",
        lower=0.0,
        upper=0.9,
        null=0.0,
        typical=0.15,
        default=0.0,
    )
    earlier: Float[Array, ""] | float = parameter(
        "1",
        "deflection at which it yields over that of the whole",
        lower=0.02,
        upper=LATEST,
        typical=0.5,
        default=0.5,
    )
    spread: Float[Array, ""] | float = part_of_it("by what share the first yields before the middle of it")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        contact = oscillator.contact
        place = 1 + self.spread * jnp.array(BEFORE_AND_AFTER)
        split = _Split(contact.k1, contact, self.share, self.earlier * place)
        return dataclasses.replace(oscillator, contact=split)


class _Split(AbstractContact):
    """State: that of `inner`, the deflections of the early elements [m].

    `inner` is the last element blown up to the whole contact: it moves a mass that is larger in the ratio
    in which it is smaller, and its answer is scaled back.
    """

    k1: Scalar
    inner: AbstractContact
    share: Scalar
    earlier: Array

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        """Where the mass slid before, the early elements have come back from there with the whole."""
        held = -approach.force / self.k1
        slid = jnp.asarray(approach.slid)
        sense = jnp.where(slid == 0, sense_of(held), slid)
        whole = traction.limit(approach.rate, sense) / self.k1
        limit = self.earlier * whole
        back = jnp.clip(self._back(jnp.maximum(whole - sense * held, 0.0), limit), 0.0, 2 * limit)
        deflection = jnp.where(slid == 0, jnp.clip(held, -limit, limit), sense * (limit - back))
        early = self._early(deflection)
        rest = approach._replace(force=(approach.force - early) / (1 - self.share))
        friction, inner = self.inner.initial(rest, self._later(traction))
        return (1 - self.share) * friction + early, (inner, deflection)

    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        inner, deflection = state
        trial = deflection + passage.slide
        limit = self._yield(passage.rate, sense_of(trial), traction)
        deflection = jnp.clip(trial, -limit, limit)
        early = self._early(deflection)
        rest = passage._replace(
            acceleration=passage.acceleration + early / passage.inertia,
            inertia=passage.inertia / (1 - self.share),
        )
        grip = self.inner.grip(inner, rest, self._later(traction))
        held = self.share * self.k1 * jnp.mean(jnp.where(jnp.abs(trial) < limit, 1.0, 0.0))
        return Grip(
            (1 - self.share) * grip.friction + early,
            (1 - self.share) * grip.mean + early,
            grip.inertia_factor * (1 + fitted_inertia(held, passage)),
            grip.slip,
            (grip.state, deflection),
        )

    def _early(self, deflection: Array) -> Array:
        """The force of the early elements [N]."""
        return -self.share * self.k1 * jnp.mean(deflection)

    def _back(self, lost: Scalar, limit: Array) -> Array:
        """How far a contact has come back [m] that slid and then lost k1 `lost` of its force. The force that
        is lost is concave in the way, each element giving no more from twice its limit on; so that of the
        lines on which none, one and more of them yield, the longest way holds."""
        each = self.share / len(BEFORE_AND_AFTER)
        yielded = jnp.arange(len(BEFORE_AND_AFTER) + 1.0)
        given = jnp.concatenate([jnp.zeros(1), jnp.cumsum(2 * each * limit)])
        return jnp.max((lost - given) / (1 - each * yielded))

    def _yield(self, rate: Scalar, sense: Scalar, traction: Traction) -> Array:
        """The deflections at which the early elements yield [m], each with a sense of its own."""
        forward, back = traction.limit(rate, 1.0), traction.limit(rate, -1.0)
        limit = jnp.where(jnp.asarray(sense) > 0, forward, back)
        return self.earlier * limit / self.k1

    def _later(self, traction: Traction) -> Traction:
        rest = 1 - self.share
        left = (1 - self.share * jnp.mean(self.earlier)) / rest
        return Traction(
            limit=lambda rate, sense: traction.limit(rate, sense) * left,
            viscous=lambda rate, sense: traction.viscous(rate, sense) / rest,
        )
