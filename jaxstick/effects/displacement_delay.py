"""A displacement channel that is late."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, NamedTuple

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.instrument import AbstractInstrument, Past, Reading
from jaxstick.parts.lag import Trail, trailed
from jaxstick.parts.motion import Motion, Scalar


class DisplacementDelay(AbstractEffect):
    """The displacement is recorded as x(t - delay).

        x(t - delay) = x - delay v + delay^2/2 a*

    holds without error if a* is the mean of the acceleration over the delay with weights that fall linearly
    with age. It is taken with exponential weights of the same mean age, delay/3: right to third order in the
    delay, and within delay^2/21 times the jump of the acceleration after an event (0.6 um for 2 ms and a jump
    of 3.5 m/s^2).
    """

    card: ClassVar[Card] = Card(
        title="Displacement channel is late",
        family="measurement",
        symptom="The recorded displacement is the true one a few milliseconds late: the mass seems to lag "
        "the base by more than its damping explains, and to move on after the force has shown the arrest.",
        explanation=(
            "The displacement was recorded by an instrument with its own clock or trigger, or its carrier "
            "demodulator or filter takes time. Away from events the delay acts like another damping, "
            "K times the delay, so an overrated damping is the first sign. A delay of the base or of the "
            "force in the other direction differs from it in one channel only."
        ),
        remedy="Feed one pulse into all channels and line them up, or let the mass strike a contact that "
        "closes a circuit; give every channel the same filter.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "dead-time elements; Taylor's theorem with the remainder as an integral.",
    )
    delay: Float[Array, ""] | float = parameter(
        "s",
        "by how much the displacement is late",
        lower=0.0,
        upper=0.05,
        null=0.0,
        typical=0.005,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(
            oscillator, instrument=_LateDisplacement(oscillator.instrument, self.delay)
        )


class _Memory(NamedTuple):
    """The mean of the acceleration over the delay [m/s^2], and the state of the inner instrument."""

    acceleration: Trail
    inner: Any


class _LateDisplacement(AbstractInstrument):
    inner: AbstractInstrument
    delay: Scalar

    def initial(self, motion: Motion, friction: Scalar, past: Past) -> _Memory:
        return _Memory(Trail(motion.a, motion.a), self.inner.initial(motion, friction, past))

    def advance(self, state: _Memory, motion: Motion, friction: Scalar, step: Scalar) -> _Memory:
        return _Memory(
            trailed(state.acceleration, motion.a, step, self.delay / 3),
            self.inner.advance(state.inner, motion, friction, step),
        )

    def read(self, state: _Memory, motion: Motion, friction: Scalar) -> Reading:
        x = motion.x - self.delay * motion.v + self.delay**2 / 2 * state.acceleration.level
        return Reading(
            self.inner.read(state.inner, motion._replace(x=x), friction).displacement,
            self.inner.read(state.inner, motion, friction).friction,
        )
