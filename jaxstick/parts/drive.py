"""The excitation: how the base moves and which force is applied, as functions of time."""

from __future__ import annotations

import abc
from typing import NamedTuple, Self

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float
from scipy.interpolate import CubicSpline

from jaxstick.parameter import parameter


class Excitation(NamedTuple):
    """Base displacement, velocity, acceleration [m, m/s, m/s^2] and applied force [N] at given times."""

    y: Array
    y_rate: Array
    y_acceleration: Array
    u: Array


class AbstractDrive(eqx.Module):
    """A function of time alone that says how the rig is excited."""

    @abc.abstractmethod
    def at(self, t: ArrayLike) -> Excitation:
        """The excitation at the times `t` [s], element by element."""


class SineDrive(AbstractDrive):
    """y = base_amplitude sin(2 pi frequency t + phase), u = force_amplitude sin(2 pi frequency t + phase)."""

    frequency: Float[Array, ""] | float = parameter("Hz", "excitation frequency", lower=0.0)
    base_amplitude: Float[Array, ""] | float = parameter("m", "amplitude of the base", default=0.0)
    force_amplitude: Float[Array, ""] | float = parameter("N", "amplitude of the force", default=0.0)
    phase: Float[Array, ""] | float = parameter("rad", "phase at time zero", default=0.0)

    def at(self, t: ArrayLike) -> Excitation:
        omega = 2 * jnp.pi * self.frequency
        angle = omega * jnp.asarray(t) + self.phase
        sine, cosine = jnp.sin(angle), jnp.cos(angle)
        amplitude = self.base_amplitude
        return Excitation(
            amplitude * sine,
            amplitude * omega * cosine,
            -amplitude * omega**2 * sine,
            self.force_amplitude * sine,
        )


class RecordedDrive(AbstractDrive):
    """A recorded base motion and force, each a cubic spline through uniformly spaced samples.

    The samples themselves are met exactly; outside the record the first or last cubic is continued.
    `base` and `force` hold the spline's coefficients, cubic term first: shape (samples - 1, 4).
    """

    start: Float[Array | np.ndarray, ""] | float
    interval: Float[Array | np.ndarray, ""] | float
    base: Float[Array | np.ndarray, "pieces 4"]
    force: Float[Array | np.ndarray, "pieces 4"]

    @classmethod
    def through(
        cls,
        start: float,
        interval: float,
        base: np.ndarray | None = None,
        force: np.ndarray | None = None,
    ) -> Self:
        """The drive through samples of the base [m], of the applied force [N], or of both.

        Raises ValueError where neither is given.
        """
        given = base if base is not None else force
        if given is None:
            raise ValueError("a recorded drive needs samples of the base or of the force")
        silent = np.zeros(len(given))
        base, force = (silent if samples is None else np.asarray(samples) for samples in (base, force))
        knots = interval * np.arange(len(given))
        pieces = [jnp.asarray(CubicSpline(knots, samples).c.T) for samples in (base, force)]
        return cls(start, interval, pieces[0], pieces[1])

    def at(self, t: ArrayLike) -> Excitation:
        elapsed = jnp.asarray(t) - self.start
        whole = jnp.clip(jnp.floor(elapsed / self.interval), 0.0, self.base.shape[-2] - 1.0)
        s = elapsed - whole * self.interval
        piece = whole.astype(jnp.int32)
        cubic, square, slope, level = jnp.moveaxis(jnp.asarray(self.base)[piece], -1, 0)
        f3, f2, f1, f0 = jnp.moveaxis(jnp.asarray(self.force)[piece], -1, 0)
        return Excitation(
            ((cubic * s + square) * s + slope) * s + level,
            (3 * cubic * s + 2 * square) * s + slope,
            6 * cubic * s + 2 * square,
            ((f3 * s + f2) * s + f1) * s + f0,
        )
