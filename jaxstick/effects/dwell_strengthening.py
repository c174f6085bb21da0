"""Static friction that grows while the contact rests."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.contact import AbstractContact, Approach, Grip, Passage, Traction
from jaxstick.parts.motion import Scalar

NEAR = 1e-6
"""So near to 0 the mean of an exponential is a straight line."""


class DwellStrengthening(AbstractEffect):
    """Multiplies the limit of the contact by 1 + growth ((1 + age/cutoff)^power - 1)/power.

    A power near 0 is the logarithm, 1 + growth ln(1 + age/cutoff); below it the growth has an end, where the
    factor is 1 - growth/power. The age [s] runs while the contact sticks, and slip by `distance` brings it
    down to 1/e. By the share `slipping` either is so in stick and slip alike: the contact ages while it
    slips, too, and what its spring gives way to renews it. With `slipping` 1 that is Dieterich's ageing law,
    age' = 1 - |v| age/distance.
    """

    card: ClassVar[Card] = Card(
        title="Static friction grows with the time of rest",
        family="friction",
        symptom=(
            "The force at breakaway is the higher the longer the stop before it, by equal steps for equal "
            "ratios of time, in both directions; slip itself is as the law says."
        ),
        explanation=(
            "At rest the asperities creep into each other and bonds form, so the real area of contact grows "
            "with the logarithm of time. Slow runs with long stops break away harder than fast ones."
        ),
        remedy=(
            "Compare runs whose stops differ in length by ten or more, at one amplitude and then at "
            "another: if the rate of loading rather than time sets the force, amplitude matters as well."
        ),
        source=(
            "Rabinowicz, The intrinsic variables affecting the stick-slip process, Proc. Phys. Soc. 71 "
            "(1958) 668; Dieterich, Time-dependent friction in rocks, J. Geophys. Res. 77 (1972) 3690."
        ),
    )
    growth: Float[Array, ""] | float = parameter(
        "1",
        "relative growth of static friction for every e-fold of rest",
        lower=0.0,
        upper=1.0,
        null=0.0,
        typical=0.03,
        default=0.0,
    )
    cutoff: Float[Array, ""] | float = parameter(
        "s", "time of rest from which on friction grows", lower=1e-6, typical=0.05, default=0.01
    )
    distance: Float[Array, ""] | float = parameter(
        "m", "distance of slip that takes the growth away", lower=1e-9, typical=2e-3, default=2e-5
    )
    power: Float[Array, ""] | float = parameter(
        "1",
        "how friction grows with time: 0 with its logarithm, above with this power of it, below to an end",
        lower=-2.0,
        upper=0.5,
        typical=0.5,
        default=0.0,
    )
    slipping: Float[Array, ""] | float = part_of_it(
        "share to which the contact ages and is renewed in stick and slip alike"
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        contact = oscillator.contact
        ageing = _Ageing(
            contact.k1,
            contact,
            self.growth,
            1 / self.cutoff,
            1 / self.distance,
            self.power,
            self.slipping,
        )
        return dataclasses.replace(oscillator, contact=ageing)


class _Ageing(AbstractContact):
    """State: that of `inner`, the age of the contact [s]."""

    k1: Scalar
    inner: AbstractContact
    growth: Scalar
    per_time: Scalar
    per_distance: Scalar
    power: Scalar
    slipping: Scalar

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        renewing = self.per_distance * jnp.abs(approach.rate)
        resting = approach.rest / (1 + self.slipping * renewing * approach.rest)
        age = jnp.where(approach.rest > 0, resting, self.slipping / (renewing + self.per_time))
        friction, inner = self.inner.initial(approach, self._aged(age, traction))
        return friction, (inner, age)

    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        inner, age = state
        grip = self.inner.grip(inner, passage, self._aged(age, traction))
        alike = self.slipping
        renewed = self.per_distance * jnp.abs(passage.slide) * (grip.slip + alike * (1 - grip.slip))
        age = (age + passage.step * (1 - (1 - alike) * grip.slip)) / (1 + renewed)
        return grip._replace(state=(grip.state, age))

    def _aged(self, age: Scalar, traction: Traction) -> Traction:
        folds = jnp.log1p(self.per_time * age)
        factor = 1 + self.growth * folds * _mean_of_exponential(self.power * folds)
        return traction._replace(limit=lambda rate, sense: traction.limit(rate, sense) * factor)


def _mean_of_exponential(end: Scalar) -> Array:
    """(exp(end) - 1)/end, 1 at 0."""
    near = jnp.abs(end) < NEAR
    return jnp.where(near, 1 + end / 2, jnp.expm1(end) / jnp.where(near, 1.0, end))
