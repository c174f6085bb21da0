"""The fit: from a data set to friction constants with honest intervals."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fitting.account import account_for
from fitting.descent import Descent
from fitting.input_noise import input_covariance
from fitting.intervals import Interval, interval
from fitting.newton import Robust, Solution
from fitting.problem import Problem, beginnings, pose, scatter
from fitting.progress import Progress, Silent
from fitting.result import Constant, Fit
from fitting.search import FINALISTS, descend_from, finish, refine
from fitting.settings import Settings
from fitting.stage import SHORTEST, Stage, ladder, stage, steps
from fitting.uncertainty import spread
from fitting.unknowns import Unknown
from jaxstick.record import CONSTANTS, AssumedConstants, DataSet

PARTING = 1.15
"""By what factor chi-square per degree of freedom may grow with longer segments before the model is said to
part from the record."""
MOST_LOST = 0.4
"""The share of longer segments that may be lost before the fit stays with the shorter ones."""
STARTS = 3
WIDE = 32


def fit(dataset: DataSet, settings: Settings | None = None, progress: Progress | None = None) -> Fit:
    """Fits A, B, C, D, k1 (and what `settings` frees besides) to the runs of a data set not held out.

    Every run is cut into segments with free starts; descents by Adam from several points choose the basin,
    Levenberg-Marquardt with the starts eliminated finishes, and intervals come from the cluster-robust
    covariance or the profile.

    Raises UserError for settings that do not suit the data, before anything long is computed.
    """
    settings = settings or Settings()
    progress = progress or Silent()
    problem = pose(dataset, settings)
    last, descent, solution = _search(problem, settings, progress)
    found = _intervals(problem, last, solution, settings, progress)
    constants = [
        _constant(unknown, at, spot, dataset.assumed)
        for unknown, at, spot in zip(problem.unknowns.members, solution.coordinates, found, strict=True)
    ]
    account = account_for(problem, last, solution, progress)
    return Fit(
        outcome="converged" if solution.converged else "the least-squares search did not converge",
        constants=tuple(constants[: len(CONSTANTS)]),
        others=tuple(constants[len(CONSTANTS) :]),
        hypothesis=last.misfit.hypothesis(solution.coordinates),
        gaps=account.gaps,
        free_runs=account.free_runs,
        chi2_per_sample=float(solution.linear.cost.sum() / last.lanes.counted().sum()),
        excluded_segments=int(np.sum(solution.weights < 0.5)),
        segments=len(last.lanes),
        horizon_periods=None if last.group is None else SHORTEST * last.group,
        traces=account.traces,
        descent=descent.history,
        finish=solution.history,
        settings=dataclasses.asdict(settings),
        sha256=dataset.sha256,
        notices=dataset.notices,
    )


def _search(problem: Problem, settings: Settings, progress: Progress) -> tuple[Stage, Descent, Solution]:
    """The best constants: on short segments from many points, then on longer ones up to the horizon."""
    rungs = ladder(problem, settings.horizon)
    here = stage(problem, rungs[0], problem.opening["k1"], settings)
    descent = descend_from(here, beginnings(problem, settings), settings, progress)
    points = descent.coordinates[np.argsort(descent.loss)[:FINALISTS]]
    solution = finish(here, points, progress)
    for group in rungs[1:]:
        longer = stage(problem, group, _k1(problem, solution), settings)
        if group is None:
            found = finish(longer, _around(problem, solution, settings), progress)
        else:
            starts = longer.starts_from(here, solution.starts)
            found = refine(longer, solution.coordinates, starts, progress)
            lost = _lost(longer, found, PARTING * _misfit(here, solution))
            if lost.mean() > MOST_LOST:
                if settings.horizon is None:
                    continue
                break
            if lost.any():
                longer, starts = _split(problem, here, solution, longer, found, lost, settings)
                found = refine(longer, found.coordinates, starts, progress)
        here, solution = longer, found
    if steps(problem, here.group, _k1(problem, solution), settings) > here.lanes.substeps:
        here = stage(problem, here.group, _k1(problem, solution), settings, here.segments)
        solution = refine(here, solution.coordinates, solution.starts, progress)
    return here, descent, solution


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
    for segment, start, gone in zip(longer.segments, found.starts, lost, strict=True):
        parts = [
            (part, own)
            for part, own in zip(here.segments, solution.starts, strict=True)
            if gone and part.run == segment.run and segment.first <= part.first < segment.last
        ]
        for part, own in parts or [(segment, start)]:
            segments.append(part)
            starts.append(own)
    return stage(problem, longer.group, _k1(problem, found), settings, segments), np.array(starts)


def _around(problem: Problem, solution: Solution, settings: Settings) -> np.ndarray:
    """Where searches on whole records begin, whose misfit is rugged: at the solution so far, around it and
    around what was read off the data."""
    first = beginnings(problem, settings)[0]
    around = [
        scatter(problem, at, WIDE // 2, settings.seed + number)
        for number, at in enumerate((solution.coordinates, first))
    ]
    return np.concatenate([solution.coordinates[None], *around])


def _intervals(
    problem: Problem, last: Stage, solution: Solution, settings: Settings, progress: Progress
) -> list[Interval]:
    unknowns, lanes = last.misfit.unknowns, last.lanes
    progress.stage("intervals", len(unknowns))
    common = input_covariance(problem, last, solution, settings.seed)
    whole = spread(last, solution).widened(common)
    robust = Robust.around(solution.linear.cost, lanes.counted())
    out = []
    for index, name in enumerate(unknowns.names):
        out.append(interval(last.misfit, lanes, solution, robust, whole, index))
        progress.advance(name)
    return out


def _constant(unknown: Unknown, at: float, found: Interval, assumed: AssumedConstants) -> Constant:
    def value(coordinate: float | None) -> float | None:
        return None if coordinate is None else float(unknown.to_value(coordinate))

    middle = float(unknown.to_value(at))
    deviation = found.deviation * (middle if unknown.kind == "log" else unknown.scale)
    return Constant(
        name=unknown.name,
        value=middle,
        low=value(found.low),
        high=value(found.high),
        unit=unknown.unit,
        assumed=getattr(assumed, unknown.name, None) if unknown.centre is None else unknown.centre,
        standard_error=deviation if math.isfinite(deviation) and deviation > 0 else None,
        method=found.method,
    )
