"""How strong an effect has to be to be named: the probability of detection."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.special import expit, logit

from fitting.blind_score.intervals import share
from fitting.blind_score.judged import MISSING, NONE, SINGLE, Judged

NINE_TENTHS = float(logit(0.9))
LEAST_CASES = 8
"""A curve is fitted to so many cases or more."""

BEYOND = 1.5
"""Times the predicted detection limit from which on nine of ten should be named."""
NAMED = 0.9

POINTS = 41


def limits(cases: Sequence[Judged]) -> dict[str, Any]:
    """The curves of all effects together, against the strength over the limit that the diagnosis predicted,
    against the gap over the detection limit of an ideal observer and over the noise; and the share named
    beyond 1.5 times either limit.

    `effects_beyond_predicted`: the share of effects of which nine of ten are named there; `not_predicted`:
    how many cases have no limit to compare with.
    """
    known = [case for case in cases if case.limit_ratio is not None]
    beyond = [case for case in known if (case.limit_ratio or 0.0) >= BEYOND]
    predicted = _over_predicted(cases)
    named: dict[str, list[bool]] = {}
    for case, ratio in predicted:
        if ratio >= BEYOND:
            named.setdefault(case.truth[0], []).append(case.right())
    return {
        "predicted_ratio": curve([ratio for _, ratio in predicted], [case.right() for case, _ in predicted]),
        "named_beyond_predicted": share(hit for hits in named.values() for hit in hits),
        "effects_beyond_predicted": share(sum(hits) >= NAMED * len(hits) for hits in named.values()),
        "not_predicted": len(cases) - len(predicted),
        "limit_ratio": curve([case.limit_ratio or 0.0 for case in known], [case.right() for case in known]),
        "gap_ratio": curve([case.gap for case in cases], [case.right() for case in cases]),
        "named_beyond": share(case.right() for case in beyond),
        "detected_beyond": share(case.verdict not in (NONE, MISSING) for case in beyond),
    }


def _over_predicted(cases: Sequence[Judged]) -> list[tuple[Judged, float]]:
    """The cases that have a strength over the limit predicted for their records, each with it."""
    ratios = ((case, predicted_ratio(case)) for case in cases)
    return [(case, ratio) for case, ratio in ratios if ratio is not None]


def predicted_ratio(case: Judged) -> float | None:
    """The strength of the one effect over the limit that the diagnosis predicts for these very records.

    Of several strengths the root of the sum of squares; one that would not show at any size counts as 0. None
    for other cases, without a prediction, and where no parameter of the truth has name and unit of a strength
    on the shelf.
    """
    if case.kind != SINGLE or case.result is None:
        return None
    key = case.truth[0]
    predicted = case.result.get("detection_limits", {}).get(key, {"strengths": {}})["strengths"]
    shares = [
        _over(true["value"], predicted[name]["limit"])
        for name, true in case.answer["effects"][key]["parameters"].items()
        if name in predicted and predicted[name]["unit"] == true["unit"]
    ]
    return math.hypot(*shares) if shares else None


def _over(value: float, limit: float | None) -> float:
    return 0.0 if limit is None else value / limit


def curve(ratios: Sequence[float], named: Sequence[bool]) -> dict[str, Any] | None:
    """The logistic curve of being named over the logarithm of a ratio (MIL-HDBK-1823A).

    a90 is the ratio at which nine of ten are named, with its 95 % interval; the rest are points for a picture
    with the pointwise 95 % band.

    Fitted with Firth's penalty (Biometrika 80 (1993) 27), which keeps it finite where all or none are named.
    None where there are fewer than eight cases or their ratios do not differ; a90 is None where the curve
    does not rise significantly.
    """
    kept = [(ratio, hit) for ratio, hit in zip(ratios, named, strict=True) if 0 < ratio < math.inf]
    if len(kept) < LEAST_CASES:
        return None
    x = np.log([ratio for ratio, _ in kept])
    y = np.array([hit for _, hit in kept], dtype=np.float64)
    if np.ptp(x) < 1e-9:
        return None
    middle = float(x.mean())
    weights, covariance = _firth(x - middle, y)
    grid = np.linspace(x.min(), x.max(), POINTS)
    design = np.stack((np.ones(POINTS), grid - middle), axis=1)
    line = design @ weights
    half = 1.96 * np.sqrt(np.einsum("pi,ij,pj->p", design, covariance, design))
    return {
        "n": len(kept),
        "a90": _a90(weights, covariance, middle),
        "ratio": np.exp(grid).tolist(),
        "probability": expit(line).tolist(),
        "low": expit(line - half).tolist(),
        "high": expit(line + half).tolist(),
        "groups": _groups(x, y),
    }


def _a90(weights: np.ndarray, covariance: np.ndarray, middle: float) -> dict[str, float] | None:
    start, slope = weights.tolist()
    if slope <= 1.96 * math.sqrt(float(covariance[1, 1])):
        return None
    centre = (NINE_TENTHS - start) / slope
    gradient = np.array([-1.0, -centre]) / slope
    half = 1.96 * math.sqrt(float(gradient @ covariance @ gradient))
    return {
        name: math.exp(min(max(middle + centre + shift, -50.0), 50.0))
        for name, shift in (("value", 0.0), ("low", -half), ("high", half))
    }


def _firth(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Intercept and slope of the penalised logistic regression, and their covariance."""
    design = np.stack((np.ones_like(x), x), axis=1)
    weights = np.zeros(2)
    covariance = np.eye(2)
    for _ in range(200):
        p = expit(design @ weights)
        w = np.maximum(p * (1 - p), 1e-12)
        covariance = np.linalg.inv(design.T @ (w[:, None] * design))
        leverage = w * np.einsum("ni,ij,nj->n", design, covariance, design)
        step = covariance @ (design.T @ (y - p + leverage * (0.5 - p)))
        longest = float(np.abs(step).max())
        weights = weights + step * min(1.0, 1.0 / max(longest, 1e-300))
        if longest < 1e-9:
            break
    return weights, covariance


def _groups(x: np.ndarray, y: np.ndarray) -> list[dict[str, Any]]:
    """The share named in groups of neighbouring ratios, for the picture."""
    order = np.argsort(x, kind="stable")
    parts = np.array_split(order, min(8, max(len(order) // 5, 1)))
    return [{"ratio": float(np.exp(x[part].mean())), "named": share(y[part] > 0.5)} for part in parts]
