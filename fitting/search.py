"""The search for the best constants: descents for the basin, least squares for the point."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fitting.descent import Descent, descend
from fitting.newton import Solution, settle, solve, unstick
from fitting.progress import Progress
from fitting.settings import Settings
from fitting.stage import Stage

DESCENT_LANES = 48
FINALISTS = 3
ATTEMPTS = 2
ROUGH = 12
FEW = 6


def descend_from(stage: Stage, points: np.ndarray, settings: Settings, progress: Progress) -> Descent:
    """Descents from every point over a sample of the lanes, spread evenly over the runs."""
    progress.stage("descent", settings.descent_iterations)
    few = np.unique(np.linspace(0, len(stage.lanes) - 1, DESCENT_LANES).round().astype(int))
    return descend(
        stage.misfit,
        stage.lanes.take(few),
        points,
        iterations=settings.descent_iterations,
        progress=lambda loss: progress.advance(f"loss {loss:.3g}"),
    )


def finish(stage: Stage, points: np.ndarray, progress: Progress) -> Solution:
    """Least squares over all lanes: roughly from each point, then to the end from the best of them."""
    progress.stage("least squares, roughly", ROUGH)
    misfit, lanes = stage.misfit, stage.lanes

    every = lanes.take(np.tile(np.arange(len(lanes)), len(points)))
    starts, _ = settle(
        misfit, every, np.repeat(points, len(lanes), axis=0), np.asarray(every.start), iterations=3
    )
    starts = starts.reshape(len(points), len(lanes), -1)
    rough = solve(misfit, lanes, points, starts, iterations=ROUGH, tolerance=1.0, progress=_teller(progress))
    leader = min(rough, key=lambda solution: solution.cost)
    return refine(stage, leader.coordinates, leader.starts, progress)


def refine(stage: Stage, coordinates: np.ndarray, starts: np.ndarray, progress: Progress) -> Solution:
    """Least squares over all lanes from one point, to the end; segments caught on the wrong side of an event
    are freed on the way."""
    misfit, lanes = stage.misfit, stage.lanes
    progress.stage("least squares", 15)

    for attempt in range(ATTEMPTS):
        (best,) = solve(
            misfit, lanes, coordinates[None], starts[None], iterations=FEW, progress=_teller(progress)
        )
        coordinates, starts = best.coordinates, best.starts
        freed = unstick(misfit, lanes, coordinates, starts, best.linear.cost, seed=attempt)
        if freed is None:
            break
        starts = freed
    (best,) = solve(misfit, lanes, coordinates[None], starts[None], progress=_teller(progress))
    return best


def _teller(progress: Progress) -> Callable[[float], None]:
    return lambda cost: progress.advance(f"chi2 {cost:.6g}")
