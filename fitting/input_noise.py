"""What the noise of the recorded base does to the constants."""

from __future__ import annotations

import jax
import numpy as np

from fitting.lanes import Misfit
from fitting.newton import Solution, reduce
from fitting.problem import Problem
from fitting.segments import lay_out
from fitting.stage import Stage

DRAWS = 12


def input_covariance(problem: Problem, stage: Stage, solution: Solution, seed: int) -> np.ndarray:
    """Covariance (p, p) of the coordinates that comes of the base being recorded with noise.

    The base drives the simulation, so its error is common to a whole run and no clustering of residuals shows
    it. Its noise is drawn anew `DRAWS` times and each draw followed by one Gauss-Newton step from the
    solution. Unknowns on a bound stay there. Zero where no base was recorded.
    """
    p = len(solution.coordinates)
    out = np.zeros((p, p))
    if all(signal.base_noise == 0 for signal in problem.chosen):
        return out
    free = np.flatnonzero(~solution.at_bound)
    settled = reduce(solution.linear, p)
    curvature = np.einsum("l,lpq->pq", solution.weights, settled.curvature)
    curvature += np.diag(problem.unknowns.prior(solution.coordinates)[2])
    random = np.random.default_rng(seed)
    rig, force = problem.dataset.rig, problem.scale.force
    draws = [
        lay_out(
            [signal.redrawn(random) for signal in problem.chosen],
            stage.segments,
            rig,
            force,
            stage.lanes.substeps,
        )
        for _ in range(DRAWS)
    ]
    lanes = jax.tree.map(lambda *leaves: np.concatenate(leaves), *draws)
    at_best = stage.misfit.hypothesis(solution.coordinates)
    misfit = Misfit(at_best, problem.unknowns, workers=stage.misfit.workers)
    each = np.broadcast_to(solution.coordinates, (len(lanes), p))
    drawn = reduce(misfit.linearise(lanes, each, np.tile(solution.starts, (DRAWS, 1))), p)
    gradients = drawn.gradient.reshape(DRAWS, -1, p) - settled.gradient
    steps = [
        np.linalg.solve(curvature[np.ix_(free, free)], (solution.weights @ gradient)[free])
        for gradient in gradients
    ]
    moved = np.array(steps)
    out[np.ix_(free, free)] = moved.T @ moved / DRAWS
    return out
