"""The way up: the best constants on short segments first, then on ever longer ones, up to the horizon."""

from __future__ import annotations

import itertools

import numpy as np

from fitting.descent import Descent
from fitting.joining import chains, join
from fitting.newton import Solution
from fitting.problem import Problem, beginnings, scatter
from fitting.progress import Progress
from fitting.search import FINALISTS, descend_from, finish, refine
from fitting.segments import Segment, cut, lay_out, merged
from fitting.settings import Settings
from fitting.stage import Stage, ladder, stage, steps, unit

PARTING = 1.15
"""By what factor chi-square per degree of freedom may grow with longer segments before the model is said to
part from the record."""
MOST_LOST = 0.4
"""The share of longer segments that may be lost before the fit stays with the shorter ones."""
STARTS = 3
WIDE = 32
"""How many more searches begin on whole records."""


def climb(problem: Problem, settings: Settings, progress: Progress) -> tuple[Stage, Descent, Solution]:
    """The best constants: descents from many points over the shortest segments, then least squares over
    longer and longer ones, each joined from those before."""
    rungs = ladder(problem, settings.horizon)
    segments = cut(problem.chosen, unit(problem))
    here = stage(problem, rungs[0], segments, problem.opening["k1"], settings)
    descent = descend_from(here, beginnings(problem, settings), settings, progress)
    points = descent.coordinates[np.argsort(descent.loss)[:FINALISTS]]
    solution = finish(here, points, progress)
    for before, group in itertools.pairwise(rungs):
        longer = np.inf if group is None or before is None else group / before
        segments = merged(segments, longer)
        found = _longer(problem, here, solution, segments, group, settings, progress)
        if found is not None:
            here, solution = found
        elif settings.horizon is not None:
            break
    if steps(problem, here.group, _k1(problem, solution), settings) > here.lanes.substeps:
        here = stage(problem, here.group, here.segments, _k1(problem, solution), settings)
        solution = refine(here, solution.coordinates, solution.starts, progress)
    return here, descent, solution


def _longer(
    problem: Problem,
    here: Stage,
    solution: Solution,
    segments: list[Segment],
    group: int | None,
    settings: Settings,
    progress: Progress,
) -> tuple[Stage, Solution] | None:
    """The stage with these longer segments and its solution; None where the model loses too many of them.

    Segments that it loses are put back into the shorter ones that they are made of.
    """
    links = chains(here.segments, segments)
    rig, substeps = problem.dataset.rig, here.lanes.substeps
    lanes = lay_out(problem.chosen, here.segments, rig, problem.scale.force, substeps, beyond=1)
    progress.stage("joining segments", len(links))
    joined = join(
        here.misfit,
        lanes,
        links,
        solution.coordinates,
        solution.starts,
        progress=lambda cost: progress.advance(f"chi2 {cost:.6g}"),
    )
    longer = stage(problem, group, segments, _k1(problem, solution), settings)
    first = [chain[0] for chain in links]
    found = refine(longer, joined.coordinates, joined.starts[first], progress)
    if group is None:
        elsewhere = finish(longer, _around(problem, solution.coordinates, settings), progress)
        return longer, min(found, elsewhere, key=lambda solution: solution.cost)
    lost = _lost(longer, found, PARTING * _misfit(here, solution))
    if lost.mean() > MOST_LOST:
        return None
    if lost.any():
        longer, starts = _split(problem, here, solution, longer, found, lost, settings)
        found = refine(longer, found.coordinates, starts, progress)
    return longer, found


def _around(problem: Problem, coordinates: np.ndarray, settings: Settings) -> np.ndarray:
    """Where further searches on whole records begin, whose misfit is rugged: at a solution, around it and
    around what was read off the data."""
    centres = (coordinates, beginnings(problem, settings)[0])
    around = [scatter(problem, at, WIDE // 2, settings.seed + number) for number, at in enumerate(centres)]
    return np.concatenate([coordinates[None], *around])


def _k1(problem: Problem, solution: Solution) -> float:
    return problem.unknowns.values(solution.coordinates)["k1"]


def _misfit(here: Stage, solution: Solution) -> float:
    """Chi-square per degree of freedom, the typical segment's."""
    return float(np.median(solution.linear.cost / (here.lanes.counted() - STARTS)))


def _lost(here: Stage, solution: Solution, level: float) -> np.ndarray:
    """Which segments the model has lost, on the wrong side of an event or for good: chi-square per degree of
    freedom beyond `level` by more than chance."""
    dof = here.lanes.counted() - STARTS
    return solution.linear.cost / dof > level * (1 + 4 * np.sqrt(2 / dof))


def _split(
    problem: Problem,
    here: Stage,
    solution: Solution,
    longer: Stage,
    found: Solution,
    lost: np.ndarray,
    settings: Settings,
) -> tuple[Stage, np.ndarray]:
    """The longer stage with each lost segment put back into the shorter ones it is made of; its starts."""
    segments, starts = [], []
    links = chains(here.segments, longer.segments)
    for segment, start, gone, chain in zip(longer.segments, found.starts, lost, links, strict=True):
        segments += [here.segments[part] for part in chain] if gone else [segment]
        starts += [solution.starts[part] for part in chain] if gone else [start]
    return stage(problem, longer.group, segments, _k1(problem, found), settings), np.array(starts)
