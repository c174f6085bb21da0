"""A wrong scale of the recorded base motion."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, ArrayLike, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.bend import bend_of
from jaxstick.parts.drive import AbstractDrive, Excitation, Extent
from jaxstick.parts.motion import Scalar


class BaseGain(AbstractEffect):
    """The base moves by y/[1 + gain (1 + bend |y|)] where y is recorded."""

    card: ClassVar[Card] = Card(
        title="Scale of the base channel is wrong",
        family="measurement",
        symptom="Mass and friction behave as if the base moved by a few percent more or less than recorded, "
        "in every run alike.",
        explanation=(
            "The calibration factor of the transducer at the base is wrong, or the point where it measures "
            "does not move as the joint of the drive spring does. Where the transducer is not linear, the "
            "percentage grows or falls with the stroke (bend). A drive stiffness other than stated does the "
            "same as a scale alone; no record of the motion tells the two apart."
        ),
        remedy="Measure the base's stroke with a dial gauge at the joint of the spring; measure the drive "
        "stiffness by itself with weights.",
        source="Equation of motion: only the product of drive stiffness and base motion enters it.",
    )
    traces: ClassVar[tuple[str, ...]] = ("scale of the drive",)
    gain: Float[Array, ""] | float = parameter(
        "1",
        "relative error of the scale of the base",
        lower=-0.5,
        upper=0.5,
        null=0.0,
        typical=0.02,
        default=0.0,
    )
    bend: Float[Array, ""] | float = bend_of("1/m", "stroke")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, drive=_ScaledBase(oscillator.drive, self.gain, self.bend))


class _ScaledBase(AbstractDrive):
    inner: AbstractDrive
    gain: Scalar
    bend: Scalar

    def at(self, t: ArrayLike) -> Excitation:
        y, rate, acceleration, u = self.inner.at(t)
        steeper = self.gain * self.bend * jnp.sign(y)
        scale = 1 + self.gain + steeper * y
        slope = (1 + self.gain) / scale**2
        bending = -2 * slope * steeper / scale
        return Excitation(y / scale, slope * rate, slope * acceleration + bending * rate**2, u)

    def extent(self) -> Extent:
        """That of the record: what is stated in its terms does not change with the gain."""
        return self.inner.extent()
