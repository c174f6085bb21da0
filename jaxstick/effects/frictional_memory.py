"""Friction that follows the sliding velocity with a lag."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.by_few import by_few
from jaxstick.parts.contact import AbstractContact, Approach, Grip, Passage, Traction
from jaxstick.parts.lag import Lag, fading, followed, passed, settled
from jaxstick.parts.motion import Scalar
from jaxstick.parts.track import Trace

INSTANT = 1e-4
"""Where the limit of the contact at another velocity than that of the start is asked for, it is taken to have
had this time [s] to follow."""


class FrictionalMemory(AbstractEffect):
    """The dry part of the law sees a speed that follows the sliding velocity v:

        w + lag w' + curvature lag^2 w'' = v,    s + lag s' + curvature lag^2 s'' = |v|
        speed = (1 - unsigned) |w| + unsigned s

    A curvature near 0 is a lag of first order; the nearer it is to 1/3 (Bessel's filter of second order), the
    nearer the lag comes to a pure delay, as which it was first described. Where the velocity itself lags, the
    speed passes through zero after every reversal, only later; a film whose thickness follows the speed keeps
    part of it. While it slides at v the lag is lag/(1 + |v|/transition): a film needs a time to settle at a
    new speed, contacts that are renewed need a distance, well above the transition that of lag times
    transition. The viscous part sees the velocity as it is. A motion that is picked up in the middle of a
    record begins with what the sliding before it has led to.
    """

    card: ClassVar[Card] = Card(
        title="Friction lags behind the velocity",
        family="friction",
        symptom=(
            "In slip the friction force over velocity is a loop: higher than the steady law while the mass "
            "speeds up, lower while it slows down. The loop opens with frequency."
        ),
        explanation=(
            "The film and the contacts between the surfaces need time, or a distance slid, to settle at a "
            "new speed. Values from 1 to 50 ms are reported for lubricated metals. A delay of the force "
            "channel does the like, but shows in stick and in the balance of forces too."
        ),
        remedy=(
            "Rule out a delay between the channels with a common pulse. Then use a law with memory, or a "
            "lubricant of lower viscosity, with which the lag shortens."
        ),
        source=(
            "Hess, Soom, Friction at a lubricated line contact operating at oscillating sliding velocities, "
            "J. Tribology 112 (1990) 147."
        ),
    )
    lag: Float[Array, ""] | float = parameter(
        "s", "time by which friction lags the velocity", lower=0.0, null=0.0, typical=0.015, default=0.0
    )
    curvature: Float[Array, ""] | float = parameter(
        "1",
        "order of the lag: 0 first, 1/4 two equal ones, 1/3 the nearest to a delay",
        lower=0.0,
        upper=0.5,
        typical=0.1,
        default=0.1,
    )
    unsigned: Float[Array, ""] | float = part_of_it(
        "share in which the size of the velocity lags, not the velocity itself, which passes through zero"
    )
    transition: Float[Array, ""] | float = parameter(
        "m/s",
        "sliding velocity above which friction follows over a distance rather than in a time",
        lower=1e-9,
        typical=100.0,
        span=(5000.0, 10.0),
        default=1e3,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        contact = oscillator.contact
        lagging = _Lagging(contact.k1, contact, self.lag, self.curvature, self.unsigned, 1 / self.transition)
        return dataclasses.replace(oscillator, contact=lagging)


class _Lags(NamedTuple):
    """What follows the sliding velocity, and what follows its size [m/s]."""

    velocity: Lag
    speed: Lag


class _Lagging(AbstractContact):
    """State: that of `inner`, and what lags behind the sliding."""

    k1: Scalar
    inner: AbstractContact
    lag: Scalar
    curvature: Scalar
    unsigned: Scalar
    per_speed: Scalar

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        if approach.rates is None:
            lags = _Lags(*(settled(rate, jnp.zeros_like(rate)) for rate in _both(approach.rate)))
        else:
            known = (approach.rate, self.lag, self.curvature, self.per_speed)
            numbers = jnp.stack([jnp.asarray(number) for number in known])
            lags = _Lags(*(Lag(*lag) for lag in by_few(_led, numbers, approach.rates)))
        follows = INSTANT / (self.lag + INSTANT)
        seen = self._seen(lags)

        def limit(rate: Scalar, sense: Scalar) -> Scalar:
            change = traction.limit(rate, sense) - traction.limit(approach.rate, sense)
            return traction.limit(seen, sense) + follows * change

        remembering = traction._replace(limit=limit)
        friction, inner = self.inner.initial(approach, remembering)
        return friction, (inner, lags)

    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        inner, lags = state
        step = passage.step + self.per_speed * jnp.abs(passage.slide)

        fades = fading(step, self.lag, self.curvature)

        def after(rate: Scalar) -> _Lags:
            return _Lags(*(passed(own, to, fades) for own, to in zip(lags, _both(rate), strict=True)))

        remembering = traction._replace(
            limit=lambda rate, sense: traction.limit(self._seen(after(rate)), sense)
        )
        grip = self.inner.grip(inner, passage, remembering)
        return grip._replace(state=(grip.state, after(passage.rate)))

    def _seen(self, lags: _Lags) -> Scalar:
        """The speed that the law sees [m/s]."""
        return (1 - self.unsigned) * jnp.abs(lags.velocity.level) + self.unsigned * lags.speed.level


def _led(numbers: Array, before: Trace) -> Array:
    """What the sliding before the start has led to, of the velocity and of its size."""
    rate, lag, curvature, per_speed = numbers
    before = before.up_to(rate)
    ages = jnp.asarray(before.lags).at[1:].add(per_speed * jnp.cumsum(before.ways()))
    traces = (Trace(ages, jnp.asarray(each)) for each in _both(jnp.asarray(before.values)))
    return jnp.stack([jnp.stack(followed(trace, lag, curvature)) for trace in traces])


def _both(rate: Scalar) -> tuple[Scalar, Scalar]:
    return rate, jnp.abs(rate)
