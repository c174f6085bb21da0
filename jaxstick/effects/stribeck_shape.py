"""A Stribeck curve of another shape than the exponential."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.friction import AbstractFriction, AbstractWrappedFriction, within
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.slowed import slowed

_STANDSTILL = 1e-9
"""Speeds below this share of the reference are not told apart from rest."""


class StribeckShape(AbstractEffect):
    """Lets the law see v0 (|v|/v0)^(1 + excess) for the sliding speed |v|, v0 the reference speed.

    A exp(-B |v|) becomes A exp(-(B' |v|)^(1 + excess)) with B'^(1 + excess) = B v0^(-excess): v0 is where the
    law keeps its value, so a change of it is the same as one of B.

    With a `tail` that, v0 u, is seen as v0 log(1 + a u)/a, a = tail |excess|: the law falls as a power of the
    speed in the end, A (1 + a u)^(-B v0/a).
    """

    card: ClassVar[Card] = Card(
        title="Stribeck curve of another shape",
        family="friction",
        symptom=(
            "Over speed, the friction force falls from its static to its dynamic level along another curve "
            "than the exponential: flatter at creep and then steeper (exponent above 1), or the other way "
            "round."
        ),
        explanation=(
            "How friction weakens with speed depends on how the film between the surfaces builds up. "
            "Exponents from 1/2 to 2 are in use; 2 is Gauss's curve; others fall as a power of the speed. "
            "The simulator has the exponential built in."
        ),
        remedy=(
            "Measure the friction force at constant speeds between a tenth and three times 1/B, where the "
            "curves differ most; then use the exponent that fits."
        ),
        source=(
            "Bo, Pavelescu, The friction-speed relation and its influence on the critical velocity of "
            "stick-slip motion, Wear 82 (1982) 277; with a tail: Hess, Soom, Friction at a lubricated "
            "line contact operating at oscillating sliding velocities, J. Tribology 112 (1990) 147."
        ),
    )
    excess: Float[Array, ""] | float = parameter(
        "1",
        "exponent of the speed in the law, less 1",
        lower=-0.8,
        upper=3.0,
        null=0.0,
        typical=0.3,
        default=0.0,
    )
    reference: Float[Array, ""] | float = parameter(
        "m/s", "speed at which the law keeps its value", lower=0.0, typical=0.3, default=0.01
    )
    tail: Float[Array, ""] | float = part_of_it("how slowly the law falls in the end, over the excess")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        def reshaped(law: AbstractFriction) -> AbstractFriction:
            return _Reshaped(law, self.excess, 1 / self.reference, self.tail)

        return dataclasses.replace(oscillator, friction=within(oscillator.friction, reshaped))


class _Reshaped(AbstractWrappedFriction):
    """Around the law itself, whatever else is attached: what else depends on the speed sees the true one."""

    inner: AbstractFriction
    excess: Scalar
    reciprocal: Scalar
    tail: Scalar

    def limit(self, state: Any, motion: Motion) -> Scalar:
        relative = jnp.maximum(jnp.abs(motion.slide_rate) * self.reciprocal, _STANDSTILL)
        power = jnp.exp(self.excess * jnp.log(relative))
        rising = power * relative
        seen = motion.slide_rate * power * slowed(rising, self.tail * jnp.abs(self.excess)) / rising
        return self.inner.limit(state, motion._replace(slide_rate=seen))

    def viscous(self, state: Any, motion: Motion) -> Scalar:
        return self.inner.viscous(state, motion)
