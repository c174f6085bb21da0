"""A force channel that is late."""

from __future__ import annotations

import dataclasses
from typing import ClassVar, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument, Past
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.tape import Tape, blank, played, taped


class ForceDelay(AbstractEffect):
    """The force is recorded as F(t - delay)."""

    card: ClassVar[Card] = Card(
        title="Force channel is late",
        family="measurement",
        symptom="The recorded force is the true one, edges and all, some milliseconds later than "
        "displacement and base; at every breakaway and arrest the motion is ahead of the force.",
        explanation=(
            "Force and displacement were recorded by instruments that do not share a clock or a trigger, or "
            "a converter samples its channels one after the other, or a digital filter adds its delay to one "
            "of them. In fast slip the late force opens force against speed to a loop, like frictional "
            "memory or a filter; unlike a filter it leaves the edges sharp, unlike memory it contradicts the "
            "equation of motion."
        ),
        remedy="Feed one pulse into all channels and line them up; record all of them with one converter "
        "that samples them at once.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "dead-time elements; L. Ljung, System Identification: Theory for the User, 2nd ed., Prentice Hall "
        "1999.",
    )
    delay: Float[Array, ""] | float = parameter(
        "s",
        "by how much the force is late",
        lower=0.0,
        upper=0.05,
        null=0.0,
        typical=0.01,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, instrument=_LateForce(oscillator.instrument, self.delay))


class _Memory(NamedTuple):
    """The force since the start, and by how much it changed in the time of the delay before the start [N]."""

    tape: Tape
    past: Past


class _LateForce(AbstractForceLink):
    """Before the start the force is taken to have changed at the rate that it has there."""

    inner: AbstractInstrument
    delay: Scalar

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> _Memory:
        return _Memory(blank(friction), past)

    def follow(self, own: _Memory, motion: Motion, friction: Scalar, step: Scalar) -> _Memory:
        return _Memory(taped(own.tape, friction, step, self.delay), own.past)

    def passed(self, own: _Memory, motion: Motion, friction: Scalar) -> Scalar:
        earlier = self.delay - own.tape.count * own.tape.step
        before = own.tape.first - own.past.change(own.tape.first, earlier)
        return jnp.where(earlier >= 0, before, played(own.tape, self.delay))
