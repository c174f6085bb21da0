"""Static friction that is higher than friction in slip, and is lost over a distance."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.contact import AbstractContact, Approach, Grip, Passage, Traction, sense_of
from jaxstick.parts.motion import Scalar
from jaxstick.parts.track import Trace

CURVED = 1e-5
"""An excess that is so little straight is as good as an exponential."""
NOTHING = 1e-12
"""An excess of which this share is left is gone."""


class SlipWeakening(AbstractEffect):
    """Multiplies the limit of the contact by 1 + peak (1 - straight s/length)^(1/straight), s the distance
    slid since it stuck: by 1 + peak exp(-s/length) with straight 0, along a line that ends at s = length with
    straight 1.

    In stick s is 0, however long or short that lasts. A motion that is picked up in the middle of a record
    has slid as far as the record before it says, less what its spring was wound up by after it turned;
    without one, a mass in motion has slid for long.
    """

    card: ClassVar[Card] = Card(
        title="Static friction stands above friction in slip",
        family="friction",
        symptom=(
            "A peak of the force at every breakaway, as high after short stops as after long ones, that is "
            "gone after a distance rather than at a speed; before it and beyond it all is as the law says."
        ),
        explanation=(
            "Junctions that have formed at rest, a bonded film or interlocked asperities, have to be torn "
            "before the surfaces slide. Once torn they carry less until the next stop. The law's own A is "
            "lost with speed, which looks alike where every breakaway speeds up alike."
        ),
        remedy=(
            "Break away slowly and fast: a peak over distance keeps its width in displacement, one over "
            "speed does not. Vary the time of rest to tell it from ageing. Running-in or a boundary additive "
            "lowers it."
        ),
        source=(
            "Ida, Cohesive force across the tip of a longitudinal-shear crack and Griffith's specific "
            "surface energy, J. Geophys. Res. 77 (1972) 3796; Rabinowicz, The nature of the static and "
            "kinetic coefficients of friction, J. Appl. Phys. 22 (1951) 1373."
        ),
    )
    peak: Float[Array, ""] | float = parameter(
        "1",
        "relative excess of static friction over what the law gives",
        lower=0.0,
        upper=1.0,
        null=0.0,
        typical=0.05,
        default=0.0,
    )
    length: Float[Array, ""] | float = parameter(
        "m",
        "distance of slip that would take the excess away were it lost as fast as at first; to 1/e of it if "
        "straight is 0",
        lower=1e-9,
        typical=2e-2,
        default=1e-4,
    )
    straight: Float[Array, ""] | float = part_of_it("how far the excess goes to an end along a straight line")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        contact = oscillator.contact
        weakening = _Weakening(contact.k1, contact, self.peak, 1 / self.length, self.straight + CURVED)
        return dataclasses.replace(oscillator, contact=weakening)


class _Weakening(AbstractContact):
    """State: that of `inner`, what is left of the excess, 0 to 1, and the share of the last window that
    slipped, by the sense of that slip."""

    k1: Scalar
    inner: AbstractContact
    peak: Scalar
    per_distance: Scalar
    straight: Scalar

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        moves = (approach.rate != 0) & (approach.rest <= 0)
        left = jnp.where(moves, 0.0, 1.0)
        if approach.rates is not None:
            still = traction.limit(0.0, sense_of(approach.rate)) / self.k1
            slid = _travelled(approach.rates, approach.rate) - (2 + self.peak) * still
            left = self._torn(1.0, jnp.where(moves, jnp.maximum(slid, 0.0), 0.0))
        friction, inner = self.inner.initial(approach, self._raised(left, traction))
        return friction, (inner, left, jnp.where(moves, sense_of(approach.rate), 0.0))

    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        inner, left, slip = state
        there = self._left(left, slip, jnp.abs(slip), passage)
        grip = self.inner.grip(inner, passage, self._raised(there, traction))
        left = self._left(left, slip, grip.slip, passage)
        return grip._replace(state=(grip.state, left, sense_of(passage.slide) * grip.slip))

    def _left(self, left: Scalar, before: Scalar, slip: Scalar, passage: Passage) -> Scalar:
        """What is left at the end of a window of which this share slips. The excess is back to the share by
        which less slips than in the window `before`, and where the sense of sliding is another."""
        onward = before * passage.slide > 0
        lasting = jnp.where(onward, jnp.minimum(slip / jnp.where(onward, jnp.abs(before), 1.0), 1.0), 0.0)
        return self._torn(1 - lasting * (1 - left), jnp.abs(passage.slide) * slip)

    def _torn(self, left: Scalar, slid: Scalar) -> Scalar:
        """What is left of the excess, of which there was `left`, after a distance slid [m]."""
        least = NOTHING**self.straight
        power = jnp.maximum(left, NOTHING) ** self.straight - self.straight * self.per_distance * slid
        return jnp.maximum(power, least) ** (1 / self.straight)

    def _raised(self, left: Scalar, traction: Traction) -> Traction:
        factor = 1 + self.peak * left
        return traction._replace(limit=lambda rate, sense: traction.limit(rate, sense) * factor)


def _travelled(rates: Trace, now: Scalar) -> Array:
    """The distance travelled in one direction up to now [m], as far back as the sliding velocities go."""
    onward = jnp.cumprod(jnp.where(jnp.asarray(rates.values) * now > 0, 1.0, 0.0))
    return jnp.sum(onward * rates.up_to(now).ways())
