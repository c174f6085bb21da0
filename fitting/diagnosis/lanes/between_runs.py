"""By how much friction differs from run to run, and what that leaves open of its constants.

Every run has a level of friction of its own, a random effect around the constants that all runs share; with
n runs their mean is known to s/sqrt(n), however well each run is. Source: the method of moments for the
variance between groups (DerSimonian, Laird, Controlled Clinical Trials 7 (1986) 177).
"""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

SURELY = 0.01
"""The probability below which runs do not differ as much by chance."""


def deviation_of_runs(levels: np.ndarray, variances: np.ndarray) -> float:
    """The standard deviation of friction between runs, as a share of itself.

    levels: those of the runs (logarithms), around their mean; variances: to which each is known so. Nought
    where they differ by no more than chance may make them (chi-square test), and for a single run, which
    tells nothing.
    """
    count = len(levels)
    if count < 2:
        return 0.0
    known = float(np.mean(variances)) * count / (count - 1)
    found = float(np.var(levels, ddof=1))
    by_chance = known * float(chi2.isf(SURELY, count - 1)) / (count - 1)
    return math.sqrt(found - known) if found > by_chance else 0.0


def uncertainty_of_mean(deviation: float, count: int, level: float, quantile: float) -> float:
    """The standard deviation to which the mean of so many runs is known that differ so, as large as makes
    `quantile` times as much the half width of Student's interval of this probability."""
    if count < 2:
        return 0.0
    return deviation / math.sqrt(count) * float(student.ppf(0.5 + level / 2, count - 1)) / quantile
