"""A wrong scale of the displacement channel."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.bend import bend_of, bent
from jaxstick.parts.instrument import AbstractInstrument, Past, Reading
from jaxstick.parts.motion import Motion, Scalar


class DisplacementGain(AbstractEffect):
    """The displacement is recorded as x + gain x (1 + bend |x|)."""

    card: ClassVar[Card] = Card(
        title="Scale of the displacement channel is wrong",
        family="measurement",
        symptom="The recorded displacement is larger or smaller than the simulated one by the same "
        "percentage in every run and phase, while the force fits.",
        explanation=(
            "The calibration factor of the displacement transducer is wrong, or the transducer is mounted at "
            "an angle or on a lever, where the scale changes along the stroke (bend). With free constants "
            "the friction law adapts its B and D; mass, damping and stiffness would have to change together. "
            "A wrong scale of the force does the same to the balance of forces, and only a static "
            "calibration of one of the two tells them apart."
        ),
        remedy="Calibrate the transducer with gauge blocks or a micrometer over the whole stroke, in the "
        "place where it is mounted.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "static calibration.",
    )
    traces: ClassVar[tuple[str, ...]] = ("scale of the forces",)
    traces_in_motion: ClassVar[tuple[str, ...]] = ("scale of the drive",)
    gain: Float[Array, ""] | float = parameter(
        "1",
        "relative error of the displacement scale",
        lower=-0.5,
        upper=0.5,
        null=0.0,
        typical=0.02,
        default=0.0,
    )
    bend: Float[Array, ""] | float = bend_of("1/m", "displacement")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        instrument = _ScaledDisplacement(oscillator.instrument, self.gain, self.bend)
        return dataclasses.replace(oscillator, instrument=instrument)


class _ScaledDisplacement(AbstractInstrument):
    inner: AbstractInstrument
    gain: Scalar
    bend: Scalar

    def initial(self, motion: Motion, friction: Scalar, past: Past) -> Any:
        return self.inner.initial(motion, friction, past)

    def advance(self, state: Any, motion: Motion, friction: Scalar, step: Scalar) -> Any:
        return self.inner.advance(state, motion, friction, step)

    def read(self, state: Any, motion: Motion, friction: Scalar) -> Reading:
        reading = self.inner.read(state, motion, friction)
        x = reading.displacement
        return reading._replace(displacement=x + self.gain * bent(x, self.bend))
