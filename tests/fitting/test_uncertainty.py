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


def stage_of(design: np.ndarray, residual: np.ndarray, runs: int = 1) -> Any:
    """What `spread` looks at of a stage: one block a lane, one cluster a lane, as many of each run."""

    def scores(lanes: Any, coordinates: Any, starts: Any, blocks: int) -> tuple[np.ndarray, np.ndarray]:
        return np.einsum("cs,csp->cp", residual, design), np.einsum("csp,csq->cpq", design, design)

    count = len(design)
    clusters = np.arange(count)[:, None]
    lanes = SimpleNamespace(counted=lambda: np.full(count, SAMPLES))
    misfit = SimpleNamespace(scores=scores, unknowns=UNKNOWNS)
    segments = tuple(SimpleNamespace(run=n * runs // count) for n in range(count))
    return SimpleNamespace(misfit=misfit, lanes=lanes, blocks=1, clusters=clusters, segments=segments)


def estimate(
    seed: int, colour: float, *, runs: int = 1, between_runs: float = 0.0, clusters: int = CLUSTERS
) -> tuple[np.ndarray, Spread]:
    """Least squares of noise about zero by a level and a slope that differs from cluster to cluster, alike in
    all runs.

    `colour` is the standard deviation of an error common to a cluster beside a white one of 1,
    `between_runs` that of one common to a run.
    """
    random = np.random.default_rng([seed, 7])
    design = np.ones((clusters, SAMPLES, P))
    design[:, :, 1] = np.tile(np.linspace(-1, 1, clusters // runs), runs)[:, None]
    noise = random.standard_normal((clusters, SAMPLES)) + colour * random.standard_normal((clusters, 1))
    noise += between_runs * np.repeat(random.standard_normal(runs), clusters // runs)[:, None]
    flat = design.reshape(-1, P)
    found = np.linalg.lstsq(flat, noise.reshape(-1), rcond=None)[0]
    residual = design @ found - noise
    solution: Any = SimpleNamespace(
        coordinates=found,
        starts=None,
        weights=np.ones(clusters),
        linear=SimpleNamespace(cost=np.sum(residual**2, axis=1)),
    )
    return found, spread(stage_of(design, residual, runs), solution)


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


def test_runs_that_disagree_are_as_many_pieces_of_evidence_as_there_are_runs():
    """The level, which differs from run to run, is known by six runs, the slope by how far it is in these."""
    kind = {"runs": 6, "clusters": 72}
    answers = [estimate(seed, 0.3, between_runs=1.0, **kind) for seed in range(600)]
    assert np.all(np.abs(coverage(answers) - 0.95) < 0.03)
    assert all(s.dof[0] == pytest.approx(6) for _, s in answers[:20])
    assert all(s.by_runs for _, s in answers[:20])


def test_runs_that_agree_are_no_clusters():
    answers = [estimate(seed, 0.3, runs=6, clusters=72) for seed in range(600)]
    assert np.all(np.abs(coverage(answers) - 0.95) < 0.03)
    assert np.mean([s.dof[0] < 10 for _, s in answers]) < 0.03
    assert np.mean([s.by_runs for _, s in answers]) < 0.03


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
