"""A zero of the force channel that drifts over a run."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.settling import RATES, settling, settling_tail, settling_time


class ForceDrift(AbstractEffect):
    """The force is recorded as F + rate s(t), t the run's own time [s]: the zero moves by `rate` at first
    and comes to rest after some `time`, s = time (1 - exp(-t/time)), s = t for a long one; with a `tail` it
    goes on, as in creep (1: s = time log(1 + t/time)) or while warmth spreads (2: as the root of t)."""

    card: ClassVar[Card] = Card(
        title="Zero of the force channel drifts",
        family="measurement",
        symptom="The recorded force rises or falls from the first cycle of a run to the last, steadily or "
        "less and less, forward and backward plateaus alike; the motion repeats itself.",
        explanation=(
            "Strain gauges and amplifiers that warm up, or a gauge adhesive that creeps under the mean load, "
            "move the zero of the force channel while the run lasts. Friction that changes over the run "
            "moves the two plateaus apart or together instead of both the same way, and changes the motion."
        ),
        remedy="Let the bridge warm up for half an hour, record the zero before and after each run, shield "
        "the table from draughts and lamps; use temperature-compensated gauges in a full bridge.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "zero drift as an interfering input.",
    )
    changes: ClassVar[bool] = True
    rate: Float[Array, ""] | float = parameter(
        "N/s",
        "rate of the zero of the force channel, at first",
        null=0.0,
        typical=6e-4,
        span=RATES,
        default=0.0,
    )
    time: Float[Array, ""] | float = settling_time()
    tail: Float[Array, ""] | float = settling_tail()

    def attach(self, oscillator: Oscillator) -> Oscillator:
        instrument = _DriftingForce(oscillator.instrument, self.rate, self.time, self.tail)
        return dataclasses.replace(oscillator, instrument=instrument)


class _DriftingForce(AbstractForceLink):
    inner: AbstractInstrument
    rate: Scalar
    time: Scalar
    tail: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        return friction + self.rate * settling(motion.t, self.time, self.tail)
