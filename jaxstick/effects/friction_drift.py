"""Friction that drifts in the course of a run."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.friction import AbstractFriction
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.scaled_friction import AbstractScaledFriction
from jaxstick.parts.settling import RATES, settling, settling_tail, settling_time


class FrictionDrift(AbstractEffect):
    """Multiplies the law by 1 + rate s(t), t the run's own time [s]: the law as it is at t = 0, which changes
    by `rate` at first and comes to rest after some `time`, s = time (1 - exp(-t/time)), s = t for a long one;
    with a `tail` it goes on (1: s = time log(1 + t/time), 2: as the root of t)."""

    card: ClassVar[Card] = Card(
        title="Friction drifts during a run",
        family="friction",
        symptom=(
            "Both plateaus of the friction force move apart (or together) from the first cycle to the last, "
            "steadily or less and less; the zero between them stays where it is."
        ),
        explanation=(
            "The surfaces change while they are tested: they run in, polish, warm up, lose lubricant or "
            "collect wear particles. A drift of the force sensor moves both plateaus the same way and is "
            "another matter."
        ),
        remedy=(
            "Run in before recording, control the temperature, keep runs short or wait until the level no "
            "longer moves; repeat the first run at the end."
        ),
        source="Blau, On the nature of running-in, Tribology International 38 (2005) 1007.",
    )
    changes: ClassVar[bool] = True
    rate: Float[Array, ""] | float = parameter(
        "1/s",
        "relative change of friction in a second, at first",
        null=0.0,
        typical=1e-3,
        span=RATES,
        default=0.0,
    )
    time: Float[Array, ""] | float = settling_time()
    tail: Float[Array, ""] | float = settling_tail()

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(
            oscillator, friction=_Drifting(oscillator.friction, self.rate, self.time, self.tail)
        )


class _Drifting(AbstractScaledFriction):
    inner: AbstractFriction
    rate: Scalar
    time: Scalar
    tail: Scalar

    def excess(self, motion: Motion) -> Scalar:
        return self.rate * settling(motion.t, self.time, self.tail)
