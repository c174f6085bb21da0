"""What a diagnosis has to beat: chance, and two simple diagnosers that read its diagnosis.json alone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from fitting.blind_score.judged import NONE, Judged

SIGNIFICANT = 3.0
"""Standard deviations of the excess below which the nearest signature is taken for noise."""


def by_bic(case: Judged) -> Judged:
    """The case as the least BIC = n log(chi2) + k log(n) over the refits answers it (Schwarz, Annals of
    Statistics 6 (1978) 461), n samples of all channels; probabilities in proportion to exp(-BIC/2)."""
    if case.result is None:
        return case
    n = max(case.samples, 2)
    nominal = 1.0 + float(case.result["where"]["excess"] or 0.0)
    weights = {(): -0.5 * n * math.log(max(nominal, 1e-12))}
    for candidate in case.result.get("candidates", ()):
        chi2 = candidate["chi2_per_sample"]
        if chi2 is not None and candidate["effects"]:
            cost = len(candidate["parameters"]) * math.log(n)
            weights[tuple(candidate["effects"])] = -0.5 * (n * math.log(max(chi2, 1e-12)) + cost)
    return _answered(case, weights)


def by_signature(case: Judged) -> Judged:
    """The case as the largest screening score of one effect answers it, nothing where the excess is not
    significant.

    Probabilities in proportion to exp(score/2), the score being a fall of chi-square.
    """
    if case.result is None:
        return case
    if (case.result["where"]["significance"] or 0.0) < SIGNIFICANT:
        return _answered(case, {(): 0.0})
    weights: dict[tuple[str, ...], float] = {
        tuple(candidate["effects"]): 0.5 * candidate["score"]
        for candidate in case.result.get("candidates", ())
        if candidate["score"] is not None and len(candidate["effects"]) == 1
    }
    return _answered(case, weights or {(): 0.0})


def _answered(case: Judged, weights: Mapping[tuple[str, ...], float]) -> Judged:
    """The case with the answer of the largest weight; weights are logarithmic."""
    best = max(weights, key=lambda keys: weights[keys])
    top = weights[best]
    shares = {keys: math.exp(max(weight - top, -700.0)) for keys, weight in weights.items()}
    total = sum(shares.values())
    probabilities = dict.fromkeys((*case.probabilities, NONE), 0.0)
    for keys, one in shares.items():
        for key in keys or (NONE,):
            probabilities[key] = probabilities.get(key, 0.0) + one / total / max(len(keys), 1)
    verdict = {0: NONE, 1: "effect"}.get(len(best), "several")
    result: dict[str, Any] = {"verdict": verdict, "named": list(best), "probabilities": probabilities}
    return replace(case, result=result)


def chance(answers: int) -> dict[str, float]:
    """What blind guessing among so many answers would score."""
    one = 1.0 / max(answers, 1)
    return {
        "right": one,
        "top1": one,
        "top1_strong": one,
        "top2": 2 * one,
        "probability": one,
        "family": 1 / 3,
        "none_called": one,
        "false_alarms": 1 - 2 * one,
        "unlisted_called": one,
        "unlisted_called_strong": one,
        "listed_called_unlisted": one,
        "auroc": 0.5,
        "log_loss": math.log(max(answers, 1)),
    }
