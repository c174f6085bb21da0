"""A force channel that does not pass constant forces."""

from __future__ import annotations

import dataclasses
from typing import ClassVar, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument, Past
from jaxstick.parts.motion import Motion, Scalar


class ForceHighpass(AbstractEffect):
    """A high-pass of first order: f = F - before - w (integral of f since the run began), w = 2 pi corner.

    With a second stage it is f = s^2/(s^2 + w s + second w^2) F: lost are w times the integral, second w^2
    times the integral of that, and before + second w (before + held) t, for a stage that has long been
    switched on holds about as much as the other has lost. In the middle of a record the integrals are those
    of the recorded force, `Before.impulse` and `Before.impulse_sum`.
    """

    card: ClassVar[Card] = Card(
        title="Force channel is coupled for alternating forces only",
        family="measurement",
        symptom="The plateaus of the recorded force sag towards zero while the sliding lasts, most in the "
        "slowest run; a force held in stick dies away, and after a reversal the force overshoots.",
        explanation=(
            "The channel blocks constant signals: an analyser input set to AC, a piezoelectric force sensor "
            "whose charge leaks away, an amplifier with a coupling capacitor, or two of these in a row. "
            "Everything that lasts longer than 1/(2 pi corner) seconds is lost. In a slow run that looks "
            "like friction that falls with the time or the length of the slip."
        ),
        remedy="Set the input to DC; with a piezoelectric sensor choose the long time constant and set it to "
        "zero just before the run; hang a weight on the table and watch whether the reading stays.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "piezoelectric transducers and the time constant of the charge amplifier.",
    )
    changes: ClassVar[bool] = True
    corner: Float[Array, ""] | float = parameter(
        "Hz", "corner frequency", lower=0.0, upper=5.0, null=0.0, typical=0.005, default=0.0
    )
    before: Float[Array, ""] | float = parameter(
        "N",
        "what the channel had lost when the run began, having been switched on before",
        null=0.0,
        typical=0.01,
        by_run=True,
        default=0.0,
    )
    held: Float[Array, ""] | float = parameter(
        "N",
        "what a second stage held when the run began, less what was lost before",
        typical=0.01,
        by_run=True,
        default=0.0,
    )
    second: Float[Array, ""] | float = part_of_it(
        "how far a second stage takes part: 0.25 where there are two alike, 0.5 in Butterworth's filter"
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(
            oscillator,
            instrument=_LeakingForce(
                oscillator.instrument, 2 * jnp.pi * self.corner, self.before, self.held, self.second
            ),
        )


class _Leak(NamedTuple):
    """What of the entering force has been lost [N], at what rate the second stage loses it [N/s], and the
    entering force [N]."""

    lost: Scalar
    losing: Scalar
    entering: Scalar


class _LeakingForce(AbstractForceLink):
    """lost' = leak (F - lost) + losing, losing' = second leak^2 (F - lost), by the trapezoidal rule."""

    inner: AbstractInstrument
    leak: Scalar
    before: Scalar
    held: Scalar
    second: Scalar

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> _Leak:
        second = self.second * self.leak
        losing = second * (self.before + self.held)
        impulse, its_sum = past.before.impulse, past.before.impulse_sum
        lost = self.before + losing * motion.t + self.leak * (impulse + second * its_sum)
        return _Leak(lost, losing + second * self.leak * impulse, friction)

    def follow(self, own: _Leak, motion: Motion, friction: Scalar, step: Scalar) -> _Leak:
        half = self.leak * step / 2
        pull = self.second * self.leak * half
        gain = half + pull * step / 2
        entering = own.entering + friction
        lost = ((1 - gain) * own.lost + step * own.losing + gain * entering) / (1 + gain)
        return _Leak(lost, own.losing + pull * (entering - own.lost - lost), friction)

    def passed(self, own: _Leak, motion: Motion, friction: Scalar) -> Scalar:
        return friction - own.lost
