"""Which parameters of a hypothesis are free, within which bounds, and how a solver sees them."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.special import expit, logit

from jaxstick.parameter import replace

RIG = "rig."
"""What the names of freed properties of the rig begin with."""


@dataclasses.dataclass(frozen=True)
class Unknown:
    """A free parameter: its name in the hypothesis, unit, bounds, and the coordinate it is searched in.

    The coordinate is the natural logarithm of the value for `log`, and value/scale for `linear`. Where a
    prior is given (`centre`, `deviation`, in units of the parameter) it weighs on the fit as a datum.
    """

    name: str
    unit: str
    lower: float
    upper: float
    kind: Literal["log", "linear"]
    scale: float = 1.0
    centre: float | None = None
    deviation: float | None = None

    def to_coordinate(self, value: Any) -> Any:
        return np.log(value) if self.kind == "log" else np.asarray(value) / self.scale

    def to_value(self, coordinate: Any) -> Any:
        return np.exp(coordinate) if self.kind == "log" else coordinate * self.scale


class Chart(eqx.Module):
    """The way from coordinates to a hypothesis, traceable; bounds and priors are not part of it, so that one
    compiled program serves data sets of every size."""

    names: tuple[str, ...] = eqx.field(static=True)
    logarithmic: tuple[bool, ...] = eqx.field(static=True)
    scale: Float[Array, " unknowns"] | np.ndarray

    def insert(self, hypothesis: Any, coordinates: Array) -> Any:
        """The hypothesis with its free parameters at these coordinates."""
        values = {
            name: jnp.exp(coordinates[i]) if logarithmic else coordinates[i] * self.scale[i]
            for i, (name, logarithmic) in enumerate(zip(self.names, self.logarithmic, strict=True))
        }
        return replace(hypothesis, values)


@dataclasses.dataclass(frozen=True)
class Unknowns:
    """An ordered set of free parameters; arrays of coordinates have them along their last axis."""

    members: tuple[Unknown, ...]

    def __len__(self) -> int:
        return len(self.members)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(unknown.name for unknown in self.members)

    def index(self, name: str) -> int:
        return self.names.index(name)

    @property
    def lower(self) -> np.ndarray:
        return np.array([unknown.to_coordinate(unknown.lower) for unknown in self.members])

    @property
    def upper(self) -> np.ndarray:
        return np.array([unknown.to_coordinate(unknown.upper) for unknown in self.members])

    def coordinates(self, values: dict[str, float]) -> np.ndarray:
        """Coordinates of the given values, moved inside the bounds where they lie on or beyond them."""
        point = [
            unknown.to_coordinate(np.clip(values[unknown.name], unknown.lower, unknown.upper))
            for unknown in self.members
        ]
        return np.array(point, float)

    def values(self, coordinates: np.ndarray) -> dict[str, float]:
        """The parameters in their own units."""
        return {
            unknown.name: float(unknown.to_value(coordinate))
            for unknown, coordinate in zip(self.members, coordinates, strict=True)
        }

    def chart(self) -> Chart:
        """What a compiled program needs to know of the unknowns."""
        return Chart(
            self.names,
            tuple(unknown.kind == "log" for unknown in self.members),
            np.array([unknown.scale for unknown in self.members]),
        )

    def to_unbounded(self, coordinates: np.ndarray) -> np.ndarray:
        """Coordinates stretched so that the bounds lie at infinity (a logit), for descent without bounds."""
        share = (coordinates - self.lower) / (self.upper - self.lower)
        return logit(np.clip(share, 1e-6, 1 - 1e-6))

    def from_unbounded(self, stretched: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates of stretched ones, and the slope of the first with respect to the second."""
        share = expit(stretched)
        width = self.upper - self.lower
        return self.lower + width * share, width * share * (1 - share)

    def prior(self, coordinates: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Twice the negative log prior, half its gradient, and half its curvature (diagonal)."""
        cost, gradient, curvature = 0.0, np.zeros(len(self)), np.zeros(len(self))
        for index, unknown in enumerate(self.members):
            if unknown.centre is None or unknown.deviation is None:
                continue
            deviation = unknown.deviation / (unknown.scale if unknown.kind == "linear" else unknown.centre)
            miss = (coordinates[index] - unknown.to_coordinate(unknown.centre)) / deviation
            cost += float(miss**2)
            gradient[index] = miss / deviation
            curvature[index] = deviation**-2
        return cost, gradient, curvature
