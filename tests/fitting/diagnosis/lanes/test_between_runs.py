"""What runs that do not all rub alike leave open of the constants."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from fitting.diagnosis.lanes.between_runs import SURELY, deviation_of_runs, uncertainty_of_mean

LEVEL, QUANTILE = 0.95, float(norm.ppf(0.975))
SETS = 4000


def differing(runs: int, between: float, known: float) -> tuple[np.ndarray, np.ndarray]:
    """Levels of the runs of many data sets, around their mean, and the mean itself, with what differs from
    run to run and what each level is known to."""
    random = np.random.default_rng(runs)
    levels = between * random.standard_normal((SETS, runs)) + known * random.standard_normal((SETS, runs))
    mean = levels.mean(1)
    return levels - mean[:, None], mean


@pytest.mark.parametrize("runs", [2, 6, 20])
def test_the_interval_of_the_mean_holds_the_truth_as_often_as_it_says(runs):
    """In 95 % of data sets the mean of all runs that there could be lies in the interval."""
    levels, mean = differing(runs, 0.08, 2e-4)
    variances = np.full(runs, 2e-4**2 * (1 - 1 / runs))
    widths = [uncertainty_of_mean(deviation_of_runs(own, variances), runs, LEVEL, QUANTILE) for own in levels]
    within = np.mean(np.abs(mean) < QUANTILE * np.array(widths))
    assert within == pytest.approx(LEVEL, abs=4 * np.sqrt(LEVEL * (1 - LEVEL) / SETS))


def test_runs_that_differ_by_chance_do_not_differ():
    levels, _ = differing(6, 0.0, 0.002)
    found = [deviation_of_runs(own, np.full(6, 0.002**2 * 5 / 6)) for own in levels]
    assert np.mean(np.array(found) > 0) == pytest.approx(SURELY, abs=0.005)


def test_what_differs_is_found_beside_what_is_not_known():
    levels, _ = differing(6, 0.02, 0.003)
    squares = [deviation_of_runs(own, np.full(6, 0.003**2 * 5 / 6)) ** 2 for own in levels]
    assert np.mean(squares) == pytest.approx(0.02**2, rel=0.05)


def test_a_single_run_says_nothing_of_others():
    assert deviation_of_runs(np.array([0.3]), np.array([1e-6])) == 0.0
    assert uncertainty_of_mean(0.1, 1, LEVEL, QUANTILE) == 0.0
