"""What an effect of the truth is: how large, of what shape, what it does to the physics or the channels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fitting.blind.physics import Elements, Physics
from fitting.blind.scales import Scales

Shape = Mapping[str, float]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RunFacts:
    """What an effect may know of the run it acts in: its place among the runs, its length [s]."""

    index: int
    duration: float


@dataclass
class Signals:
    """The channels of one run on a fine uniform grid, from before the record's start on, SI.

    acceleration is that of the mass; time is 0 at the first sample of the record. A chain effect replaces
    displacement, friction or base by what its sensor makes of it.
    """

    time: Floats
    step: float
    displacement: Floats
    velocity: Floats
    acceleration: Floats
    friction: Floats
    base: Floats


def _same_physics(physics: Physics, strength: float, shape: Shape, run: RunFacts) -> Physics:
    del strength, shape, run
    return physics


def _same_elements(elements: Elements, strength: float, shape: Shape) -> Elements:
    del strength, shape
    return elements


def _same_series(series: Floats, time: Floats, strength: float, shape: Shape, run: RunFacts) -> Floats:
    del time, strength, shape, run
    return series


def _same_signals(signals: Signals, strength: float, shape: Shape, run: RunFacts) -> None:
    del signals, strength, shape, run


def _nothing(scales: Scales) -> float:
    del scales
    return 0.0


def no_shape(scales: Scales, random: np.random.Generator) -> Shape:
    """An effect that its strength describes."""
    del scales, random
    return {}


@dataclass(frozen=True, kw_only=True)
class Formulation:
    """One effect in one form.

    key: its name in the catalogue, or a name of ours for what no catalogue lists; version: "A" for the
    catalogue's formula, "B" and "B2" for others of the same effect, "unlisted". `strength` names the
    parameter that is drawn [unit]; 0 is no effect. typical, most: its size to begin with and the largest
    sensible one; least: a size below which it hides behind what is known of the rig only to a per cent;
    signed: whether it may be negative. shape draws further parameters (absolute, SI) with their units.

    physics, elements, series, chain: what the effect does to the constants, the contact's elements, the
    factor on friction over time, and the channels. drive: the base as the records show it, where that is not
    the true one.
    """

    key: str
    version: str
    strength: str
    unit: str
    typical: Callable[[Scales], float]
    most: Callable[[Scales], float]
    least: Callable[[Scales], float] = _nothing
    signed: bool = True
    shape: Callable[[Scales, np.random.Generator], Shape] = no_shape
    shape_units: Mapping[str, str] | None = None
    physics: Callable[[Physics, float, Shape, RunFacts], Physics] = _same_physics
    elements: Callable[[Elements, float, Shape], Elements] = _same_elements
    series: Callable[[Floats, Floats, float, Shape, RunFacts], Floats] = _same_series
    chain: Callable[[Signals, float, Shape, RunFacts], None] = _same_signals
    drive: Callable[[Physics, float, Shape, RunFacts], Physics] = _same_physics
    parameters: Callable[[float, Shape], Mapping[str, float]] | None = None

    @property
    def measures(self) -> bool:
        """Whether it acts on the channels alone."""
        return self.chain is not _same_signals

    def described(self, strength: float, shape: Shape) -> dict[str, dict[str, float | str]]:
        """Its parameters as the catalogue names them, each with value and unit."""
        if self.parameters is not None:
            named = dict(self.parameters(strength, shape))
        else:
            named = {self.strength: strength, **shape}
        units = {self.strength: self.unit, **(self.shape_units or {})}
        return {name: {"value": value, "unit": units.get(name, "1")} for name, value in named.items()}


def between(random: np.random.Generator, low: float, high: float) -> float:
    """A number from low to high, even in its logarithm."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def angle(random: np.random.Generator) -> float:
    """An angle [rad]."""
    return float(random.uniform(0.0, 2.0 * np.pi))
