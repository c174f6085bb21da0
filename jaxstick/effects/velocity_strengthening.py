"""Friction that grows with the speed of sliding, but not in proportion to it."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.friction import AbstractFriction, AbstractWrappedFriction
from jaxstick.parts.kept import kept
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.scaled_friction import LEAST_FACTOR


class VelocityStrengthening(AbstractEffect):
    """Adds F_s [growth ln(1 + |v|/reference) + film v^2] to the limit of friction, F_s the limit at rest.

    The logarithm is the direct term of rate-and-state friction, the square that of a film which is dragged
    along; what grows in proportion, D |v|, is in the law already. Negative ones weaken it, but
    leave a twentieth of the law's own limit.
    """

    card: ClassVar[Card] = Card(
        title="Friction grows with the logarithm or the square of the speed",
        family="friction",
        symptom=(
            "Beyond the speeds at which it weakens, the friction force goes on to change by equal steps for "
            "equal ratios of the speed, or grows ever steeper, where the law knows a straight line only; the "
            "same in both directions, at any place and after any stop."
        ),
        explanation=(
            "Junctions are sheared by thermally activated creep, which makes them the stronger the faster "
            "they are sheared, with the logarithm of the rate: dry polymers, paper, rock, boundary films. "
            "A film that is dragged along resists with the square of the speed. A viscous slope that was "
            "fitted at some speeds is wrong at others."
        ),
        remedy=(
            "Measure the friction force at constant speeds over two decades and plot it over the logarithm "
            "of the speed: a straight line there is the logarithm, a bend upwards a film. Then use that law."
        ),
        source=(
            "Dieterich, Modeling of rock friction, J. Geophys. Res. 84 (1979) 2161; Baumberger, Caroli, "
            "Solid friction from stick-slip down to pinning and aging, Advances in Physics 55 (2006) 279."
        ),
    )
    growth: Float[Array, ""] | float = parameter(
        "1",
        "growth of friction for every e-fold of speed, in units of its limit at rest",
        lower=-1.0,
        upper=1.0,
        null=0.0,
        typical=0.02,
        default=0.0,
    )
    reference: Float[Array, ""] | float = parameter(
        "m/s", "speed from which on friction grows with its logarithm", lower=0.0, typical=0.05, default=1e-3
    )
    film: Float[Array, ""] | float = parameter(
        "s^2/m^2",
        "growth of friction over the squared speed, in units of its limit at rest",
        null=0.0,
        typical=5e-3,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        growing = _Growing(oscillator.friction, self.growth, 1 / self.reference, self.film)
        return dataclasses.replace(oscillator, friction=growing)


class _Growing(AbstractWrappedFriction):
    inner: AbstractFriction
    growth: Scalar
    reciprocal: Scalar
    film: Scalar

    def limit(self, state: Any, motion: Motion) -> Scalar:
        own = self.inner.limit(state, motion)
        speed = jnp.abs(motion.slide_rate)
        added = self.growth * jnp.log1p(speed * self.reciprocal) + self.film * speed**2
        return kept(jnp.maximum(own + added * self.inner.static(state, motion), LEAST_FACTOR * own))

    def viscous(self, state: Any, motion: Motion) -> Scalar:
        return self.inner.viscous(state, motion)
