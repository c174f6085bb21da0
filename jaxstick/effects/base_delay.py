"""A base channel that is late."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, ArrayLike, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter
from jaxstick.parts.drive import AbstractDrive, Excitation, Extent
from jaxstick.parts.motion import Scalar


class BaseDelay(AbstractEffect):
    """The base does at time t what is recorded at t + delay; an applied force is not shifted.

    The record is read at the shifted time rather than expanded around t: the second derivative of a spline
    through noisy samples is far noisier than the spline. Where a drive ends, its last piece is continued.
    """

    card: ClassVar[Card] = Card(
        title="Base channel is late",
        family="measurement",
        symptom="The mass answers to the base a few milliseconds too early, or too late where the delay is "
        "negative; displacement and force agree with each other.",
        explanation=(
            "The base was recorded by an instrument with its own clock or trigger, or through a filter that "
            "the other channels do not have. To first order the delay acts as a damper between "
            "mass and base of drive stiffness times the delay; only the base's sharp turns, or a run with "
            "the base at rest, tell the two apart."
        ),
        remedy="Feed one pulse into all channels and line them up; record the free decay with the base at "
        "rest, which a damper changes and a delay does not.",
        source="Taylor expansion of the equation of motion: k y(t + delay) = k y + k delay y'.",
    )
    traces: ClassVar[tuple[str, ...]] = ("timing of the base",)
    delay: Float[Array, ""] | float = parameter(
        "s",
        "by how much the base is late",
        lower=-0.05,
        upper=0.05,
        null=0.0,
        typical=0.005,
        default=0.0,
    )

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, drive=_LateBase(oscillator.drive, self.delay))


class _LateBase(AbstractDrive):
    inner: AbstractDrive
    delay: Scalar

    def at(self, t: ArrayLike) -> Excitation:
        return self.inner.at(jnp.asarray(t) + self.delay)._replace(u=self.inner.at(t).u)

    def extent(self) -> Extent:
        return self.inner.extent()
