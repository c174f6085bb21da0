"""What one case is made of: everything that its records follow from, in plain numbers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fitting.blind.physics import Elements, Physics


@dataclass(frozen=True, kw_only=True)
class RunPlan:
    """One run: drive [Hz, m, rad], samples recorded, samples before that to settle, level of friction."""

    frequency: float
    amplitude: float
    phase: float
    samples: int
    settling: int
    level: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Chosen:
    """An effect that acts: which formulation, how strongly, in what shape."""

    key: str
    version: str
    strength: float
    shape: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Channel:
    """How a channel is recorded: noise [SI], the converter's step [SI], the unit and decimals of its column.

    correlation: of neighbouring samples of the noise; slow: share of the noise's variance that wanders.
    """

    noise: float
    quantum: float
    correlation: float
    slow: float
    unit: str
    decimals: int
    width: int

    @property
    def deviation(self) -> float:
        """The standard deviation of noise and digitising together."""
        return math.hypot(self.noise, self.quantum / math.sqrt(12.0))


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """One case.

    physics: the rig and the friction without drive and effects; elements of the contact; scatter: relative
    standard deviation of the friction over time, with correlation time [s]; interval between samples [s];
    averaged: whether a sample is the mean over a quarter of its interval or the value at its instant; seed:
    of noise and scatter; stated: what rig.toml says; base: None where the base is not recorded.
    """

    tier: str
    physics: Physics
    elements: Elements
    scatter: float
    scatter_time: float
    interval: float
    runs: tuple[RunPlan, ...]
    effects: tuple[Chosen, ...]
    displacement: Channel
    friction: Channel
    base: Channel | None
    averaged: bool
    seed: int
    stated: Mapping[str, Any]

    def plain(self) -> dict[str, Any]:
        """The recipe in JSON's own types."""
        return dataclasses.asdict(self)


def recipe_from(plain: Mapping[str, Any]) -> Recipe:
    """The recipe that `Recipe.plain` was made of."""
    channel = {
        name: None if plain[name] is None else Channel(**plain[name])
        for name in ("displacement", "friction", "base")
    }
    return Recipe(
        **{
            **plain,
            **channel,
            "physics": Physics(**plain["physics"]),
            "elements": Elements(*(tuple(plain["elements"][name]) for name in ("stiffness", "limit"))),
            "runs": tuple(RunPlan(**run) for run in plain["runs"]),
            "effects": tuple(Chosen(**effect) for effect in plain["effects"]),
        }
    )
