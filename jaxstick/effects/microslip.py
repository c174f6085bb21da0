"""A contact of which a part yields before the whole slips."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
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


class Microslip(AbstractEffect):
    """Splits the contact into two elements side by side, of which one yields early.

    Of the stiffness k1 the early element has `share`, and yields at the deflection earlier g/k1; the other
    has the rest, and of the limit g what the first leaves. Initial stiffness and force in full slip stay as
    they are: k1 and g.
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
            "the rest still hold. The contact creeps a little before it breaks away, and small oscillations "
            "in stick die down by friction, the larger the faster."
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
        upper=0.98,
        typical=0.5,
        default=0.5,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        contact = oscillator.contact
        return dataclasses.replace(oscillator, contact=_Split(contact.k1, contact, self.share, self.earlier))


class _Split(AbstractContact):
    """State: that of `inner`, the deflection of the early element [m].

    `inner` is the later element blown up to the whole contact: it moves a mass that is larger in the ratio
    in which it is smaller, and its answer is scaled back.
    """

    k1: Scalar
    inner: AbstractContact
    share: Scalar
    earlier: Scalar

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        """Where the mass slid before, the early element has come back from there with the whole."""
        held = -approach.force / self.k1
        slid = jnp.asarray(approach.slid)
        sense = jnp.where(slid == 0, sense_of(held), slid)
        whole = traction.limit(approach.rate, sense) / self.k1
        limit = self.earlier * whole
        back = jnp.clip(whole - sense * held, 0.0, 2 * limit)
        deflection = jnp.where(slid == 0, jnp.clip(held, -limit, limit), sense * (limit - back))
        early = -self.share * self.k1 * deflection
        rest = approach._replace(force=(approach.force - early) / (1 - self.share))
        friction, inner = self.inner.initial(rest, self._later(traction))
        return (1 - self.share) * friction + early, (inner, deflection)

    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        inner, deflection = state
        trial = deflection + passage.slide
        limit = self._yield(passage.rate, sense_of(trial), traction)
        deflection = jnp.clip(trial, -limit, limit)
        early = -self.share * self.k1 * deflection
        rest = passage._replace(
            acceleration=passage.acceleration + early / passage.inertia,
            inertia=passage.inertia / (1 - self.share),
        )
        grip = self.inner.grip(inner, rest, self._later(traction))
        held = jnp.where(jnp.abs(trial) < limit, self.share * self.k1, 0.0)
        return Grip(
            (1 - self.share) * grip.friction + early,
            (1 - self.share) * grip.mean + early,
            grip.inertia_factor * (1 + fitted_inertia(held, passage)),
            grip.slip,
            (grip.state, deflection),
        )

    def _yield(self, rate: Scalar, sense: Scalar, traction: Traction) -> Scalar:
        """The deflection at which the early element yields [m]."""
        return self.earlier * traction.limit(rate, sense) / self.k1

    def _later(self, traction: Traction) -> Traction:
        rest = 1 - self.share
        left = (1 - self.share * self.earlier) / rest
        return Traction(
            limit=lambda rate, sense: traction.limit(rate, sense) * left,
            viscous=lambda rate, sense: traction.viscous(rate, sense) / rest,
        )
