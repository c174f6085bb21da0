"""A stage of a fit: the problem seen through segments of one length."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fitting.lanes import Lanes, Misfit
from fitting.problem import Problem
from fitting.segments import Segment, cut, lay_out
from fitting.settings import Settings
from jaxstick.simulate import shortest_period, substeps

CLUSTER_PERIODS = 5.0
MOST_SUBSTEPS = 64


@dataclasses.dataclass(frozen=True)
class Stage:
    """Segments of about `length` seconds (whole runs where None), as lanes with their compiled misfit.

    `clusters` numbers stretches of runs whose errors may be correlated: one number a lane and block, where a
    lane is cut into `blocks` equal blocks of samples.
    """

    length: float | None
    segments: tuple[Segment, ...]
    lanes: Lanes
    misfit: Misfit
    blocks: int
    clusters: np.ndarray


def lengths(problem: Problem, horizon: float | None) -> list[float | None]:
    """The lengths of segments on the way to the horizon: from one natural period on, each four times the
    last, so that the last stage, often full of local minima, begins in the right basin."""
    longest = max(signal.run.interval * len(signal.run.time) for signal in problem.chosen)
    periods = longest / problem.period if horizon is None else horizon
    steps = max(0, math.ceil(math.log(max(periods, 1.0), 4) - 0.5))
    ladder: list[float | None] = [problem.period * min(1.0, periods) * 4.0**i for i in range(steps)]
    return [*ladder, None if horizon is None else horizon * problem.period]


def stage(problem: Problem, length: float | None, k1: float, settings: Settings) -> Stage:
    """The stage with segments of this length; the integration step is chosen for a contact of stiffness k1.

    Raises UserError for a run with fewer samples than a segment.
    """
    chosen = problem.chosen
    segments = cut(chosen, length)
    lanes = lay_out(chosen, segments, problem.dataset.rig, problem.scale.force, steps(problem, k1, settings))
    misfit = Misfit(problem.hypothesis, problem.unknowns, lanes=len(lanes), workers=settings.workers)
    cluster = CLUSTER_PERIODS * problem.period
    span = max((segment.last - segment.first) * chosen[segment.run].run.interval for segment in segments)
    blocks = max(1, round(span / cluster))
    return Stage(
        length, tuple(segments), lanes, misfit, blocks, _clusters(problem, segments, blocks, cluster)
    )


def steps(problem: Problem, k1: float, settings: Settings) -> int:
    """Integration steps a sample for a contact of stiffness k1 [N/m].

    Where friction was not recorded, a contact so stiff that its deflection drowns in the noise of the
    displacement need not have its ring resolved.
    """
    if all(signal.run.friction is None for signal in problem.chosen):
        k1 = min(k1, problem.scale.force / max(signal.displacement_noise for signal in problem.chosen))
    nominal = problem.hypothesis.nominal
    contact = dataclasses.replace(nominal.contact, k1=k1)
    period = shortest_period(dataclasses.replace(nominal, contact=contact))
    interval = max(signal.run.interval for signal in problem.chosen)
    return min(substeps(interval, period, settings.resolution), MOST_SUBSTEPS)


def _clusters(problem: Problem, segments: list[Segment], blocks: int, length: float) -> np.ndarray:
    """A number for the stretch of `length` seconds that each block (lanes, blocks) lies in."""
    samples = max(segment.last - segment.first for segment in segments)
    labels: dict[tuple[int, int], int] = {}
    out = np.zeros((len(segments), blocks), int)
    for lane, segment in enumerate(segments):
        interval = problem.chosen[segment.run].run.interval
        for block in range(blocks):
            middle = (segment.first + (block + 0.5) * samples / blocks) * interval
            out[lane, block] = labels.setdefault((segment.run, int(middle // length)), len(labels))
    return out
