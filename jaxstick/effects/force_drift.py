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
from jaxstick.parts.settling import settling, settling_time


class ForceDrift(AbstractEffect):
    """The force is recorded as F + rate time (1 - exp(-t/time)), with t the run's own time [s]: the zero
    moves by `rate` at first and comes to rest after some `time`; F + rate t for a long one."""

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
        "N/s", "rate of the zero of the force channel, at first", null=0.0, typical=6e-4, default=0.0
    )
    time: Float[Array, ""] | float = settling_time()

    def attach(self, oscillator: Oscillator) -> Oscillator:
        instrument = _DriftingForce(oscillator.instrument, self.rate, self.time)
        return dataclasses.replace(oscillator, instrument=instrument)


class _DriftingForce(AbstractForceLink):
    inner: AbstractInstrument
    rate: Scalar
    time: Scalar

    def passed(self, own: Any, motion: Motion, friction: Scalar) -> Scalar:
        return friction + self.rate * settling(motion.t, self.time)
