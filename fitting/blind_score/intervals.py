"""Figures of a score with their 95 % intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from scipy.stats import beta, binom

LEVEL = 0.95
RESAMPLES = 2000

Figure = dict[str, Any]
"""value, low, high (None where there is nothing to count), n, and for shares the number of hits."""


def share(hits: Iterable[bool]) -> Figure:
    """The share of hits with the exact binomial interval (Clopper and Pearson, Biometrika 26 (1934) 404).

    low = the a/2 quantile of Beta(k, n - k + 1), high = the 1 - a/2 quantile of Beta(k + 1, n - k).
    """
    found = [bool(hit) for hit in hits]
    n, k = len(found), sum(found)
    if not n:
        return {"value": None, "low": None, "high": None, "hits": 0, "n": 0}
    tail = (1 - LEVEL) / 2
    low = float(beta.ppf(tail, k, n - k + 1)) if k else 0.0
    high = float(beta.ppf(1 - tail, k + 1, n - k)) if k < n else 1.0
    return {"value": k / n, "low": low, "high": high, "hits": k, "n": n}


def mean(values: Sequence[float]) -> Figure:
    """The mean, with the percentile interval of 2000 resamples (always the same ones)."""
    if not len(values):
        return {"value": None, "low": None, "high": None, "n": 0}
    data = np.asarray(values, dtype=np.float64)
    draws = np.random.default_rng(0).integers(len(data), size=(RESAMPLES, len(data)))
    low, high = np.quantile(data[draws].mean(axis=1), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return {"value": float(data.mean()), "low": float(low), "high": float(high), "n": len(data)}


def quantile(values: Sequence[float], level: float) -> Figure:
    """A quantile with its distribution-free interval between two order statistics; the interval is open
    (None) on a side where so few values do not bound it."""
    data = np.sort(np.asarray([value for value in values if math.isfinite(value)], dtype=np.float64))
    n = len(data)
    if not n:
        return {"value": None, "low": None, "high": None, "n": 0}
    tail = (1 - LEVEL) / 2
    below = int(binom.ppf(tail, n, level))
    if binom.cdf(below, n, level) > tail:
        below -= 1
    above = int(binom.ppf(1 - tail, n, level))
    return {
        "value": float(np.quantile(data, level)),
        "low": float(data[below]) if below >= 0 else None,
        "high": float(data[above]) if above < n else None,
        "n": n,
    }


def area(positive: Sequence[float], negative: Sequence[float]) -> Figure:
    """The area under the ROC curve, ties counted half, with the interval of Hanley and McNeil (Radiology 143
    (1982) 29)."""
    n, m = len(positive), len(negative)
    if not n or not m:
        return {"value": None, "low": None, "high": None, "n": n + m}
    high, low = np.asarray(positive)[:, None], np.asarray(negative)[None, :]
    value = float(np.mean((high > low) + 0.5 * (high == low)))
    q1, q2 = value / (2 - value), 2 * value**2 / (1 + value)
    variance = (value * (1 - value) + (n - 1) * (q1 - value**2) + (m - 1) * (q2 - value**2)) / (n * m)
    half = 1.96 * math.sqrt(max(variance, 0.0))
    return {"value": value, "low": max(value - half, 0.0), "high": min(value + half, 1.0), "n": n + m}
