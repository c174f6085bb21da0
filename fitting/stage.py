"""A stage of a fit: the problem seen through segments of one length."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fitting.lanes import Lanes, Misfit
from fitting.problem import Problem
from fitting.segments import Segment, lay_out
from fitting.settings import Settings
from jaxstick.simulate import shortest_period, substeps

CLUSTER_PERIODS = 5.0
SHORTEST = 0.25
GROWTH = 8
SUBSTEPS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)
"""The numbers of integration steps a sample that are used: few, so that programs are seldom recompiled."""


@dataclasses.dataclass(frozen=True)
class Stage:
    """Segments of `group` units, a quarter of a natural period each (whole runs where None), as lanes with
    their compiled misfit.

    `clusters` numbers stretches of runs whose errors may be correlated: one number a lane and block, where a
    lane is cut into `blocks` equal blocks of samples.
    """

    group: int | None
    segments: tuple[Segment, ...]
    lanes: Lanes
    misfit: Misfit
    blocks: int
    clusters: np.ndarray


def unit(problem: Problem) -> float:
    """The length of the shortest segments [s], in which the misfit has hardly any local minima."""
    return SHORTEST * problem.period


def ladder(problem: Problem, horizon: float | None) -> list[int | None]:
    """The groups of units on the way to the horizon: each `GROWTH` times the last, none longer than the
    shortest run; the whole run last where the horizon is None."""
    spans = [signal.run.interval * len(signal.run.time) for signal in problem.chosen]
    longest = max(spans) if horizon is None else min(horizon * problem.period, min(spans))
    last = max(1, round(longest / unit(problem)))
    groups: list[int | None] = []
    group = 1
    while group * math.sqrt(GROWTH) < last:
        groups.append(group)
        group *= GROWTH
    return [*groups, None if horizon is None else last]


def stage(
    problem: Problem, group: int | None, segments: Sequence[Segment], k1: float, settings: Settings
) -> Stage:
    """The stage with these segments, of `group` units or shorter; the integration step is chosen for a
    contact of stiffness k1."""
    chosen = problem.chosen
    number = steps(problem, group, k1, settings)
    lanes = lay_out(chosen, segments, problem.dataset.rig, problem.scale.force, number)
    misfit = Misfit(problem.hypothesis, problem.unknowns, workers=settings.workers)
    cluster = CLUSTER_PERIODS * problem.period
    span = max((segment.last - segment.first) * chosen[segment.run].run.interval for segment in segments)
    blocks = max(1, round(span / cluster))
    clusters = _clusters(problem, segments, blocks, cluster)
    return Stage(group, tuple(segments), lanes, misfit, blocks, clusters)


def steps(problem: Problem, group: int | None, k1: float, settings: Settings) -> int:
    """Integration steps a sample for segments of `group` units and a contact of stiffness k1 [N/m].

    The longer the segments, the more they tell and the finer the steps must be: the resolution grows with
    the fourth root of the length, from what `settings` says at a quarter of a natural period on. Whole
    records that are followed whether or not the model fits ask for no more than that.

    Where friction was not recorded, a contact so stiff that its deflection drowns in the noise of the
    displacement need not have its ring resolved.
    """
    if all(signal.run.friction is None for signal in problem.chosen):
        k1 = min(k1, problem.scale.force / max(signal.displacement_noise for signal in problem.chosen))
    nominal = problem.hypothesis.nominal
    contact = dataclasses.replace(nominal.contact, k1=k1)
    period = shortest_period(dataclasses.replace(nominal, contact=contact))
    interval = max(signal.run.interval for signal in problem.chosen)
    growth = 1.0 if group is None else group**0.25
    wanted = substeps(interval, period, settings.resolution * growth)
    return next((number for number in SUBSTEPS if number >= wanted), SUBSTEPS[-1])


def _clusters(problem: Problem, segments: Sequence[Segment], blocks: int, length: float) -> np.ndarray:
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
