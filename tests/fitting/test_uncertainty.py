"""The cluster-robust covariance on a straight-line problem where everything is known."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.uncertainty import Spread, spread
from fitting.unknowns import Unknown, Unknowns

CLUSTERS, SAMPLES, P = 12, 30, 2
UNKNOWNS = Unknowns(tuple(Unknown(name, "1", -9.0, 9.0, "linear") for name in "ab"))


def stage_of(design: np.ndarray, residual: np.ndarray) -> Any:
    """What `spread` looks at of a stage: one block a lane, one cluster a lane."""

    def scores(lanes: Any, coordinates: Any, starts: Any, blocks: int) -> tuple[np.ndarray, np.ndarray]:
        return np.einsum("cs,csp->cp", residual, design), np.einsum("csp,csq->cpq", design, design)

    clusters = np.arange(CLUSTERS)[:, None]
    lanes = SimpleNamespace(counted=lambda: np.full(CLUSTERS, SAMPLES))
    misfit = SimpleNamespace(scores=scores, unknowns=UNKNOWNS)
    return SimpleNamespace(misfit=misfit, lanes=lanes, blocks=1, clusters=clusters)


def estimate(seed: int, colour: float) -> tuple[np.ndarray, Spread]:
    """Least squares of noise about zero by a level and a slope that differs from cluster to cluster.

    `colour` is the standard deviation of an error common to a cluster beside a white one of 1.
    """
    random = np.random.default_rng([seed, 7])
    design = np.ones((CLUSTERS, SAMPLES, P))
    design[:, :, 1] = np.linspace(-1, 1, CLUSTERS)[:, None]
    noise = random.standard_normal((CLUSTERS, SAMPLES)) + colour * random.standard_normal((CLUSTERS, 1))
    flat = design.reshape(-1, P)
    found = np.linalg.lstsq(flat, noise.reshape(-1), rcond=None)[0]
    residual = design @ found - noise
    solution: Any = SimpleNamespace(
        coordinates=found,
        starts=None,
        weights=np.ones(CLUSTERS),
        linear=SimpleNamespace(cost=np.sum(residual**2, axis=1)),
    )
    return found, spread(stage_of(design, residual), solution)


def coverage(answers: list[tuple[np.ndarray, Spread]]) -> np.ndarray:
    return np.mean([np.abs(found) < s.quantile() * s.deviation() for found, s in answers], axis=0)


def test_intervals_of_coloured_residuals_cover_the_truth_as_often_as_they_say():
    answers = [estimate(seed, 1.0) for seed in range(1000)]
    assert np.all(np.abs(coverage(answers) - 0.95) < 0.022)
    covariance = np.mean([s.covariance for _, s in answers], axis=0)
    np.testing.assert_allclose(np.diag(covariance), np.var([f for f, _ in answers], axis=0), rtol=0.15)


def test_intervals_of_white_residuals_cover_the_truth_and_are_never_narrower_than_the_model_says():
    answers = [estimate(seed, 0.0) for seed in range(1000)]
    assert np.all(coverage(answers) > 0.94)
    assert all(np.all(s.inflation() > 1 - 1e-9) for _, s in answers)
    assert np.all(np.mean([s.inflation() for _, s in answers], axis=0) < 1.4)


def test_inflation_is_that_of_coloured_over_white_residuals():
    """White residuals of the same typical size: the median of 1 + chi^2 with one degree of freedom."""
    coloured = np.mean([estimate(seed, 1.0)[1].inflation() for seed in range(300)], axis=0)
    np.testing.assert_allclose(coloured, (1.0 + SAMPLES) / 1.455, rtol=0.25)


def test_degrees_of_freedom_count_the_clusters_that_carry_a_coordinate():
    _, found = estimate(0, 0.0)
    assert found.dof[0] == pytest.approx(CLUSTERS)
    x = np.linspace(-1, 1, CLUSTERS)
    assert found.dof[1] == pytest.approx((x**2).sum() ** 2 / (x**4).sum())


def test_another_source_of_error_adds():
    _, found = estimate(0, 0.0)
    np.testing.assert_allclose(found.widened(np.eye(P)).covariance, found.covariance + np.eye(P))
