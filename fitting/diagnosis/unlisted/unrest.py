"""Friction that scatters within segments by more than friction can that merely wanders between them."""

from __future__ import annotations

import dataclasses

import numpy as np

from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.repeatability import wander_of
from fitting.diagnosis.noise.scatter import Scatter
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly
from fitting.problem import Problem

RESTLESS = 3.0
"""Friction that scatters within segments by more than so many times the noise of its sensor,"""
WITHIN = 3.0
"""and by more than so many times what it wanders by from one segment to the next, does not wander: the mean
of a segment, a natural period long, would change as well, were its memory as long as a twentieth of that."""


@dataclasses.dataclass(frozen=True)
class Unrest(AbstractAnomaly):
    """Scatter that is no wandering; `wander`: by how many percent friction differs between segments."""

    wander: float

    @property
    def clause(self) -> str:
        return (
            "what does not repeat itself from cycle to cycle is more than friction that wanders, which "
            f"changes by {self.wander:.2g} % only from segment to segment"
        )

    @property
    def look(self) -> str:
        return (
            "Record the same run several times, each started alike: what comes back in all of them is made "
            "by the drive, the place or the time since the start, and is no chance."
        )


def unrest(problem: Problem, model: Model, fit: Refit, scatter: Scatter | None) -> Unrest | None:
    """What there is of it, to judge by what friction does from segment to segment under a hypothesis; None
    without a friction force."""
    noises = [signal.friction_noise for signal in problem.chosen if signal.friction_noise is not None]
    if scatter is None or not noises:
        return None
    times, wander = scatter.most()[1], wander_of(fit)
    level = sum(model.values(fit.point.coordinates, ("A", "C")).values())
    restless = times > RESTLESS and bool(times * np.median(noises) > WITHIN * wander / 100 * level)
    return Unrest(wander) if restless else None
