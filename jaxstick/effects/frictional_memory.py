"""Friction that follows the sliding velocity with a lag."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.contact import AbstractContact, Approach, Grip, Passage, Traction
from jaxstick.parts.motion import Scalar

NO_TIME = 1e-9
"""A time [s] that nothing happens in: it stands for none where one divides by it."""
INSTANT = 1e-4
"""Where the limit of the contact at another velocity than that of the start is asked for, it is taken to have
had this time [s] to follow."""


class FrictionalMemory(AbstractEffect):
    """The dry part of the law sees the sliding velocity w through a first-order lag: lag w' = v - w.

    Across a step from v0 to v1 the lag is taken implicitly, w1 = v1 + lag/(lag + h) (w0 - v1), so that it
    vanishes smoothly with the lag. The viscous part keeps the velocity itself. A motion that is picked up in
    the middle of a record begins with the w that the sliding before it has led to.
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

    def attach(self, oscillator: Oscillator) -> Oscillator:
        contact = oscillator.contact
        return dataclasses.replace(oscillator, contact=_Lagging(contact.k1, contact, self.lag))


class _Lagging(AbstractContact):
    """State: that of `inner`, the lagging velocity [m/s]."""

    k1: Scalar
    inner: AbstractContact
    lag: Scalar

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        lagging = approach.rate
        if approach.rates is not None:
            lagging = approach.rates.followed(self.lag + NO_TIME, approach.rates.oldest()[0])
        follows = INSTANT / (self.lag + INSTANT)

        def limit(rate: Scalar, sense: Scalar) -> Scalar:
            change = traction.limit(rate, sense) - traction.limit(approach.rate, sense)
            return traction.limit(lagging, sense) + follows * change

        remembering = traction._replace(limit=limit)
        friction, inner = self.inner.initial(approach, remembering)
        return friction, (inner, lagging)

    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        inner, lagging = state
        weight = self.lag / (self.lag + passage.step)

        def seen(rate: Scalar) -> Scalar:
            return rate + weight * (lagging - rate)

        remembering = traction._replace(limit=lambda rate, sense: traction.limit(seen(rate), sense))
        grip = self.inner.grip(inner, passage, remembering)
        return grip._replace(state=(grip.state, seen(passage.rate)))
