"""A base channel that is late."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, ArrayLike, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.drive import AbstractDrive, Excitation, Extent
from jaxstick.parts.motion import Scalar


class BaseDelay(AbstractEffect):
    """The base does at time t what is recorded at t + delay; an applied force is not shifted.

    By the share `rounded` of the delay the record lags behind the base as an RC filter does, of which the
    base is y = r + lag r', r the record at t + delay - lag. The rest of it is read at the shifted time
    rather than expanded around t: the second derivative of a spline through noisy samples is far noisier than
    the spline. Where a drive ends, its last piece is continued.
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
    rounded: Float[Array, ""] | float = part_of_it("share of the delay that an RC filter has")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        lag = self.rounded * self.delay
        return dataclasses.replace(oscillator, drive=_LateBase(oscillator.drive, self.delay - lag, lag))


class _LateBase(AbstractDrive):
    inner: AbstractDrive
    delay: Scalar
    lag: Scalar

    def at(self, t: ArrayLike) -> Excitation:
        t = jnp.asarray(t, float)
        read, rate = jax.jvp(self.inner.at, (t + self.delay,), (jnp.ones_like(t),))
        base = jax.tree.map(lambda value, change: value + self.lag * change, read, rate)
        return base._replace(u=self.inner.at(t).u)

    def extent(self) -> Extent:
        return self.inner.extent()
