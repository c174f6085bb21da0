"""Contacts that give way gradually: bristles, and elements side by side of which one yields after another.

Unlike the contact of the 1987 paper these creep before they break away. In full slip, and in the stiffness of
a fresh stick, they are the same: g(|v|) + D|v| and k1.
"""

from __future__ import annotations

import abc
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

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
from jaxstick.parts.decay import mean_decay
from jaxstick.parts.motion import Scalar

ELEMENTS = 4
ROUNDING = 1e-9
"""By what share a deflection may fall short of the limit that it was cut to."""


class BristleState(NamedTuple):
    """Deflection of the bristles, and that of full slip at the present velocity [m]."""

    deflection: Scalar
    full: Scalar


class AbstractBristle(AbstractContact):
    """z' = v (1 - alpha sign(v) z/z_ss) with z_ss = g(|v|)/k1, and F = -k1 z - D v.

    alpha, from 0 to 1, says how much of the sliding the bristles give way by; every subclass has its own.
    Over a step z follows the exact solution at the alpha in its middle and the mean z_ss: second order.
    """

    @abc.abstractmethod
    def plasticity(self, load: Scalar) -> Scalar:
        """alpha at a load k1 z/g, positive where sliding increases it."""

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, BristleState]:
        limit = traction.limit(approach.rate, sense_of(-approach.force))
        deflection = -jnp.clip(approach.force, -limit, limit) / self.k1
        drag = traction.viscous(approach.rate, sense_of(approach.rate)) * approach.rate
        return -self.k1 * deflection - drag, BristleState(deflection, limit / self.k1)

    def grip(self, state: BristleState, passage: Passage, traction: Traction) -> Grip:
        start, before = state
        sense = sense_of(passage.slide)
        after = traction.limit(passage.rate, sense) / self.k1
        full = (before + after) / 2
        middle = _followed(start, passage.slide / 2, full, self.plasticity(sense * start / full))
        plasticity = self.plasticity(sense * middle / full)
        deflection = _followed(start, passage.slide, full, plasticity)
        slip = jnp.clip(plasticity * sense * deflection / full, 0.0, 1.0)
        friction = -self.k1 * deflection - traction.viscous(passage.rate, sense) * passage.rate
        factor = 1 + fitted_inertia(self.k1 * (1 - slip), passage)
        return Grip(friction, friction, factor, slip, BristleState(deflection, after))


class LuGreContact(AbstractBristle):
    """Bristles that give way from the first on, alpha = 1: the LuGre model with sigma_0 = k1, sigma_1 = 0.

    Source: Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419.
    """

    k1: Float[Array, ""] | float = parameter("N/m", "stiffness of a fresh stick", lower=0.0)

    def plasticity(self, load: Scalar) -> Scalar:
        return jnp.ones_like(load)


class ElastoPlasticContact(AbstractBristle):
    """Bristles that are elastic up to the share `breakaway` of the limit: alpha rises from 0 there to 1 at
    the limit along half a sine, and is 0 while they unload.

    Source: Dupont, Hayward, Armstrong, Altpeter, IEEE Trans. Automatic Control 47 (2002) 787.
    """

    k1: Float[Array, ""] | float = parameter("N/m", "stiffness of the contact in stick", lower=0.0)
    breakaway: Float[Array, ""] | float = parameter(
        "1", "share of the limit at which yielding begins", lower=0.0, upper=0.98, typical=0.7, default=0.7
    )

    def plasticity(self, load: Scalar) -> Scalar:
        share = jnp.clip((load - self.breakaway) / (1 - self.breakaway), 0.0, 1.0)
        return 0.5 - 0.5 * jnp.cos(jnp.pi * share)


class IwanContact(AbstractContact):
    """Elastic-plastic elements side by side, equally stiff, whose limits are spread evenly over
    (1 - spread) g to (1 + spread) g of the whole's.

    In stick the force runs back along the same spring k1 after a reversal and bends as one element after
    another yields, on a branch twice as large as the first (Masing): elements that begin in stick have come
    back along it from the sliding before, or else have never yielded.
    Source: Iwan, J. Appl. Mech. 33 (1966) 893.
    """

    k1: Float[Array, ""] | float = parameter("N/m", "stiffness of the contact in stick", lower=0.0)
    spread: Float[Array, ""] | float = parameter(
        "1", "half range of the elements' limits", lower=0.01, upper=0.9, typical=0.15, default=0.15
    )

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Scalar]:
        sense = sense_of(-approach.force)
        limits = self._limits(traction.limit(approach.rate, sense))
        whole = jnp.mean(limits)
        wanted = jnp.clip(-approach.force / self.k1, -whole, whole)
        slid = jnp.asarray(approach.slid)
        pulled = _pulled(jnp.where(slid == 0, sense * wanted, (whole - slid * wanted) / 2), limits)
        deflections = jnp.where(slid == 0, sense * pulled, slid * (limits - 2 * pulled))
        slips = (sense * deflections > limits * (1 - ROUNDING)) & (sense * approach.rate > 0)
        drag = traction.viscous(approach.rate, sense) * approach.rate * _share(slips, limits)
        return -self.k1 * jnp.mean(deflections) - drag, deflections

    def grip(self, state: Scalar, passage: Passage, traction: Traction) -> Grip:
        trial = state + passage.slide
        sense = sense_of(passage.slide)
        limits = self._limits(traction.limit(passage.rate, sense))
        slips = sense * trial > limits
        deflections = jnp.where(slips, sense * limits, trial)
        slip = _share(slips, limits)
        drag = traction.viscous(passage.rate, sense) * passage.rate * slip
        friction = -self.k1 * jnp.mean(deflections) - drag
        factor = 1 + fitted_inertia(self.k1 * (1 - jnp.mean(slips.astype(float))), passage)
        return Grip(friction, friction, factor, slip, deflections)

    def _limits(self, limit: Scalar) -> Array:
        """The deflections at which the elements yield [m]."""
        return limit / self.k1 * (1 + self.spread * jnp.linspace(-1.0, 1.0, ELEMENTS))


def _pulled(mean: Scalar, limits: Array) -> Array:
    """The deflections of elements that are pulled from rest until their mean is so much."""
    reach = mean
    for _ in range(ELEMENTS):
        held = jnp.maximum(jnp.mean((reach < limits).astype(float)), 1 / ELEMENTS)
        reach = reach + (mean - jnp.mean(jnp.minimum(reach, limits))) / held
    return jnp.minimum(reach, limits)


def _share(slips: Array, limits: Array) -> Scalar:
    """The share of the whole's limit that is that of elements which slip; of the viscous force they have as
    much."""
    return jnp.sum(jnp.where(slips, limits, 0.0)) / jnp.sum(limits)


def _followed(start: Scalar, slide: Scalar, full: Scalar, plasticity: Scalar) -> Scalar:
    """The bristles' deflection after sliding by `slide`: the solution of dz = dx - plasticity z/full |dx|."""
    exponent = plasticity * jnp.abs(slide) / full
    return start + slide * (1 - plasticity * sense_of(slide) * start / full) * mean_decay(exponent)
