"""What may explain the records: one effect or several, refitted."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.which.screen import Promise

TOLD_APART = 3.3
"""Explanations are of different classes from this d' of signal detection theory on: where either is as
likely, Phi(-d'/2) = 5 % of the cases are taken for the other."""


@dataclasses.dataclass(frozen=True)
class Explanation:
    """One effect or several, refitted, with the promise that brought it on the short list."""

    keys: tuple[str, ...]
    promise: Promise
    refit: Refit

    def fitted(self, refit: Refit) -> Explanation:
        """The same effects, fitted otherwise."""
        return dataclasses.replace(self, refit=refit)


def best_of(explanations: Sequence[Explanation]) -> list[Explanation]:
    """Of explanations by the same effects the one with the lowest misfit; the best first."""
    best: dict[frozenset[str], Explanation] = {}
    for one in explanations:
        rival = best.get(frozenset(one.keys))
        if rival is None or one.refit.misfit < rival.refit.misfit:
            best[frozenset(one.keys)] = one
    return sorted(best.values(), key=lambda one: one.refit.misfit)


def separation(one: Explanation, other: Explanation) -> float:
    """By how much the other costs more than the one, in standard deviations of that sum over segments."""
    difference = other.refit.cost - one.refit.cost
    spread = float(np.std(difference)) * math.sqrt(len(difference))
    return float(difference.sum()) / max(spread, 1e-300)


def told_apart(one: Explanation, other: Explanation) -> bool:
    """Whether the records tell the two apart: sums of squares in units of noise differ by d'^2 on average,
    with a standard deviation of 2 d', or what it is over segments."""
    difference = abs(float((other.refit.cost - one.refit.cost).sum()))
    return difference > TOLD_APART**2 and abs(separation(one, other)) > TOLD_APART / 2


def fitted_again(model: Model, bench: Bench, explanations: Sequence[Explanation]) -> list[Explanation]:
    """Explanations fitted to a bench from where they stand, in the same order."""
    fits = refit(model, bench, [e.refit.point for e in explanations], [e.refit.free for e in explanations])
    return [e.fitted(fit) for e, fit in zip(explanations, fits, strict=True)]
