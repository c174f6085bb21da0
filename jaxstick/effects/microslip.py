"""A contact of which a part yields before the whole slips."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
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

APART = np.array([-1.0, 0.0, 1.0])
"""How far the early elements lie from their middle, in units of their spread."""


class Microslip(AbstractEffect):
    """Splits the contact into elements side by side, of which some yield early.

    Of the stiffness k1 three early elements have `share` in equal parts, and yield at the deflections
    (1 - spread) earlier g/k1, earlier g/k1 and (1 + spread) earlier g/k1: without spread they are one. What
    is left has the rest of the stiffness, and of the limit g what they leave. Initial stiffness and force in
    full slip stay as they are: k1 and g.
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
    spread: Float[Array, ""] | float = parameter(
        "1",
        "how far the deflections at which its parts yield differ from that",
        lower=0.0,
        upper=0.9,
        typical=0.3,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        contact = oscillator.contact
        split = _Split(contact.k1, contact, self.share, self.earlier, self.spread)
        return dataclasses.replace(oscillator, contact=split)


class _Split(AbstractContact):
    """State: that of `inner`, the deflections of the early elements [m].

    `inner` is the later element blown up to the whole contact: it moves a mass that is larger in the ratio
    in which it is smaller, and its answer is scaled back.
    """

    k1: Scalar
    inner: AbstractContact
    share: Scalar
    earlier: Scalar
    spread: Scalar

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        """Where the mass slid before, the early elements have come back from there with the whole."""
        held = -approach.force / self.k1
        slid = jnp.asarray(approach.slid)
        sense = jnp.where(slid == 0, sense_of(held), slid)
        whole = traction.limit(approach.rate, sense) / self.k1
        limits = self._fractions() * whole
        loaded = jnp.minimum(self._travel(sense * held, limits), limits)
        back = jnp.minimum(self._travel(whole - sense * held, 2 * limits), 2 * limits)
        deflections = sense * jnp.where(slid == 0, loaded, limits - back)
        early = self._early(deflections)
        rest = approach._replace(force=(approach.force - early) / (1 - self.share))
        friction, inner = self.inner.initial(rest, self._later(traction))
        return (1 - self.share) * friction + early, (inner, deflections)

    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        inner, deflections = state
        trial = deflections + passage.slide
        limits = self._yield(passage.rate, sense_of(trial), traction)
        deflections = jnp.clip(trial, -limits, limits)
        early = self._early(deflections)
        rest = passage._replace(
            acceleration=passage.acceleration + early / passage.inertia,
            inertia=passage.inertia / (1 - self.share),
        )
        grip = self.inner.grip(inner, rest, self._later(traction))
        held = self.share * self.k1 * jnp.mean(jnp.where(jnp.abs(trial) < limits, 1.0, 0.0))
        return Grip(
            (1 - self.share) * grip.friction + early,
            (1 - self.share) * grip.mean + early,
            grip.inertia_factor * (1 + fitted_inertia(held, passage)),
            grip.slip,
            (grip.state, deflections),
        )

    def _fractions(self) -> Array:
        """The deflections at which the early elements yield, over that of the whole."""
        return jnp.asarray(self.earlier * (1 + self.spread * APART))

    def _travel(self, force: Scalar, ranges: Array) -> Scalar:
        """How far the contact has been moved where that took a force, over k1 [m], and the early elements
        give way after these ranges, which grow: the force over the way is the least of straight lines, one
        for each of the elements that may have given way."""
        given = jnp.arange(len(APART) + 1) / len(APART)
        taken = jnp.concatenate([jnp.zeros(1), jnp.cumsum(ranges)]) / len(APART)
        return jnp.max((jnp.maximum(force, 0.0) - self.share * taken) / (1 - self.share * given))

    def _early(self, deflections: Scalar) -> Scalar:
        """The force of the early elements [N]."""
        return -self.share * self.k1 * jnp.mean(deflections)

    def _yield(self, rate: Scalar, senses: Scalar, traction: Traction) -> Scalar:
        """The deflections at which the early elements yield [m]."""
        return self._fractions() * traction.limit(rate, senses) / self.k1

    def _later(self, traction: Traction) -> Traction:
        rest = 1 - self.share
        left = (1 - self.share * self.earlier) / rest
        return Traction(
            limit=lambda rate, sense: traction.limit(rate, sense) * left,
            viscous=lambda rate, sense: traction.viscous(rate, sense) / rest,
        )
