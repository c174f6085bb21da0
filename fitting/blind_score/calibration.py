"""Whether probabilities mean what they say."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fitting.blind_score.intervals import mean, share
from fitting.blind_score.judged import PAIR, Judged

BINS = 10
LEAST = 1e-6
"""A probability below this counts as this in the log-loss, that of a missing answer too."""

PERFECT = 2000
"""Simulated perfect diagnosers."""


def calibration(cases: Sequence[Judged]) -> dict[str, Any]:
    """Reliability of the likeliest answer, exact aliases counted as one.

    Pairs have no single right answer and stay out; cases without a diagnosis have no confidence and count in
    the log-loss alone. Bins of equal number (Naeini, Cooper and Hauskrecht, AAAI 2015). The expected
    calibration error is the sum over bins of n_b/n |share right - mean confidence|; `perfect` is the 95 %
    quantile, by simulation, of that of a diagnoser whose answers are right with exactly the stated
    probabilities. Log-loss in nat, Brier score of the likeliest answer.
    """
    single = [case for case in cases if case.kind != PAIR]
    answered = [case for case in single if case.result is not None]
    confidence = np.array([case.confidence() for case in answered])
    hits = np.array([case.likeliest_is_right() for case in answered], dtype=np.float64)
    groups = _groups(confidence)
    losses = [-math.log(max(case.probability(), LEAST)) for case in single]
    return {
        "bins": [
            {
                "low": float(confidence[group].min()),
                "high": float(confidence[group].max()),
                "confidence": float(confidence[group].mean()),
                "right": share(hits[group] > 0.5),
            }
            for group in groups
        ],
        "ece": _ece(confidence, hits[None, :], groups)[0] if groups else None,
        "perfect": _perfect(confidence, groups) if groups else None,
        "n": len(answered),
        "log_loss": mean(losses),
        "brier": mean(((confidence - hits) ** 2).tolist()),
    }


def _groups(confidence: np.ndarray) -> list[np.ndarray]:
    """The numbers of the cases in each bin, from low to high confidence."""
    if not len(confidence):
        return []
    order = np.argsort(confidence, kind="stable")
    return [group for group in np.array_split(order, min(BINS, len(order))) if len(group)]


def _ece(confidence: np.ndarray, hits: np.ndarray, groups: list[np.ndarray]) -> list[float]:
    """The ECE of each row of hits."""
    parts = [np.abs(np.sum(hits[:, group] - confidence[group], axis=1)) for group in groups]
    return (np.sum(parts, axis=0) / len(confidence)).tolist()


def _perfect(confidence: np.ndarray, groups: list[np.ndarray]) -> float:
    draws = np.random.default_rng(0).random((PERFECT, len(confidence))) < confidence
    return float(np.quantile(_ece(confidence, draws.astype(np.float64), groups), 0.95))
