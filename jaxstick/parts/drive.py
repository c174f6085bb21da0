"""The excitation: how the base moves and which force is applied, as functions of time."""

from __future__ import annotations

import abc
import math
from typing import NamedTuple, Self

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float
from scipy.interpolate import CubicSpline

from jaxstick.parameter import parameter
from jaxstick.turns import sine_and_cosine


class Excitation(NamedTuple):
    """Base displacement, velocity, acceleration [m, m/s, m/s^2] and applied force [N] at given times."""

    y: Array
    y_rate: Array
    y_acceleration: Array
    u: Array


class Extent(NamedTuple):
    """How far an excitation goes: base displacement, base velocity and force [m, m/s, N], each sqrt(2) times
    its standard deviation, which is the amplitude where it is a sine."""

    y: Array | float
    y_rate: Array | float
    u: Array | float


class AbstractDrive(eqx.Module):
    """A function of time alone that says how the rig is excited."""

    @abc.abstractmethod
    def at(self, t: ArrayLike) -> Excitation:
        """The excitation at the times `t` [s], element by element."""

    @abc.abstractmethod
    def extent(self) -> Extent:
        """How far the excitation goes in the run."""


class SineDrive(AbstractDrive):
    """y = base_amplitude sin(2 pi frequency t + phase), u = force_amplitude sin(2 pi frequency t + phase)."""

    frequency: Float[Array, ""] | float = parameter("Hz", "excitation frequency", lower=0.0)
    base_amplitude: Float[Array, ""] | float = parameter("m", "amplitude of the base", default=0.0)
    force_amplitude: Float[Array, ""] | float = parameter("N", "amplitude of the force", default=0.0)
    phase: Float[Array, ""] | float = parameter("rad", "phase at time zero", default=0.0)

    def at(self, t: ArrayLike) -> Excitation:
        omega = 2 * jnp.pi * self.frequency
        sine, cosine = sine_and_cosine(self.frequency * jnp.asarray(t) + self.phase / (2 * jnp.pi))
        amplitude = self.base_amplitude
        return Excitation(
            amplitude * sine,
            amplitude * omega * cosine,
            -amplitude * omega**2 * sine,
            self.force_amplitude * sine,
        )

    def extent(self) -> Extent:
        return Extent(
            self.base_amplitude, 2 * jnp.pi * self.frequency * self.base_amplitude, self.force_amplitude
        )


class RecordedDrive(AbstractDrive):
    """A recorded base motion and force, each a cubic spline through uniformly spaced samples.

    The samples themselves are met exactly; outside the record the first or last cubic is continued.
    `base` and `force` hold the spline's coefficients, cubic term first: shape (samples - 1, 4). `whole` is
    the extent of the run; where it is not given, that of the pieces held here stands in for it.
    """

    start: Float[Array | np.ndarray, ""] | float
    interval: Float[Array | np.ndarray, ""] | float
    base: Float[Array | np.ndarray, "pieces 4"]
    force: Float[Array | np.ndarray, "pieces 4"]
    whole: Extent | None = None

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
        return cls(start, interval, pieces[0], pieces[1], extent_of(pieces[0], pieces[1]))

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

    def extent(self) -> Extent:
        return extent_of(self.base, self.force) if self.whole is None else self.whole

    def continued(self, pieces: int) -> Self:
        """The same drive with so many pieces: the last cubic is written out as often as there is room. For
        numpy arrays, `base` and `force` with any leading axes, `interval` with the same."""

        def whole(part: Array | np.ndarray) -> np.ndarray:
            part = np.asarray(part)
            more = np.arange(1, pieces - part.shape[-2] + 1)
            shift = more * np.asarray(self.interval)[..., None]
            cubic, square, slope, level = (part[..., -1, n, None] for n in range(4))
            coefficients = (
                cubic + 0 * shift,
                square + 3 * cubic * shift,
                slope + (2 * square + 3 * cubic * shift) * shift,
                level + (slope + (square + cubic * shift) * shift) * shift,
            )
            return np.concatenate([part, np.stack(coefficients, axis=-1)], axis=-2)

        return eqx.tree_at(lambda d: (d.base, d.force), self, (whole(self.base), whole(self.force)))


def extent_of(
    base: Float[Array | np.ndarray, "pieces 4"], force: Float[Array | np.ndarray, "pieces 4"]
) -> Extent:
    """The extent of a recorded drive from its coefficients, cubic term first."""
    base, force = jnp.asarray(base), jnp.asarray(force)
    columns = base[..., 3], base[..., 2], force[..., 3]
    return Extent(*(math.sqrt(2) * jnp.std(column, axis=-1) for column in columns))
