"""The fit: from a data set to friction constants with honest intervals."""

from __future__ import annotations

import dataclasses
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from fitting.account import account_for
from fitting.climb import climb
from fitting.input_noise import input_covariance
from fitting.intervals import Interval, interval
from fitting.newton import Robust, Solution
from fitting.problem import Problem, pose
from fitting.progress import Progress, Silent
from fitting.result import Constant, Fit
from fitting.settings import Settings
from fitting.stage import SHORTEST, Stage
from fitting.uncertainty import spread
from fitting.unknowns import Unknown
from jaxstick.record import CONSTANTS, DataSet


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
    last, descent, solution = climb(problem, settings, progress)
    found, runs_disagree = _intervals(problem, last, solution, settings, progress)
    constants = [
        _constant(unknown, at, spot, dataset)
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
        runs_disagree=runs_disagree,
    )


def _intervals(
    problem: Problem, last: Stage, solution: Solution, settings: Settings, progress: Progress
) -> tuple[list[Interval], bool]:
    """The interval of every unknown, and whether the runs surely disagree on some."""
    unknowns, lanes = last.misfit.unknowns, last.lanes
    progress.stage("intervals", len(unknowns))
    with ThreadPoolExecutor(2) as pool:
        common = pool.submit(input_covariance, problem, last, solution, settings.seed)
        whole = spread(last, solution).widened(common.result())
    robust = Robust.around(solution.linear.cost, lanes.counted())
    out = []
    for index, name in enumerate(unknowns.names):
        out.append(interval(last.misfit, lanes, solution, robust, whole, index))
        progress.advance(name)
    return out, whole.by_runs


def _constant(unknown: Unknown, at: float, found: Interval, dataset: DataSet) -> Constant:
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
        assumed=_stated(unknown, dataset),
        standard_error=deviation if math.isfinite(deviation) and deviation > 0 else None,
        method=found.method,
    )


def _stated(unknown: Unknown, dataset: DataSet) -> float | None:
    """What the rig file says of an unknown."""
    if unknown.centre is not None:
        return unknown.centre
    key, _, name = unknown.name.rpartition(".")
    return dataset.effects.get(key, {}).get(name) if key else getattr(dataset.assumed, name)
