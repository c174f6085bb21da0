"""Single samples of the motion that are off, as no effect on the shelf makes them."""

from __future__ import annotations

import dataclasses

import numpy as np

from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly
from fitting.problem import Problem
from jaxstick.check import quantity
from jaxstick.noise import estimate_noise
from jaxstick.outliers import outliers

FEWEST = 5
"""So many are no accident,"""
OFTEN = 0.5
"""nor are some in more than this share of the runs. In 10 of 10 sealed cases with bit errors there were 9 to
70, in five and six of six runs; in none of 990 others there was one."""


@dataclasses.dataclass(frozen=True)
class BadSamples(AbstractAnomaly):
    """How many single samples of the displacement are off, in how many runs, of how many, and by how much at
    the most [m]."""

    count: int
    runs: int
    of: int
    most: float

    @property
    def clause(self) -> str:
        return (
            f"single samples of the displacement are off, by up to {quantity(self.most, 'm')}, as bit errors "
            "or a loose plug make them"
        )

    @property
    def note(self) -> str:
        return (
            f"In {self.runs} of {self.of} runs single samples of the displacement, {self.count} in all, are "
            f"off by up to {quantity(self.most, 'm')}, which no motion does: look for bit errors of the "
            "converter, a loose plug, sparks of a drive, or lost words on the way to the file."
        )

    @property
    def look(self) -> str:
        return (
            "Record with the mass at rest, the drive and its amplifier off and then on, and again with "
            "another cable and plug: samples that are off there as well owe nothing to the motion."
        )

    @property
    def side(self) -> str:
        return "measurement"


def bad_samples(problem: Problem) -> BadSamples | None:
    """What there is of them in the runs that are not left out; None where there are few."""
    records = [signal.run.displacement for signal in problem.chosen]
    off = [outliers(record, estimate_noise(record))[1] for record in records]
    runs, sizes = sum(len(each) > 0 for each in off), np.abs(np.concatenate(off))
    if len(sizes) < FEWEST or runs <= OFTEN * len(off):
        return None
    return BadSamples(len(sizes), runs, len(off), float(sizes.max()))
