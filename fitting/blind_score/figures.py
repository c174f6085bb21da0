"""The figures of a set of judged cases, or of one tier of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fitting.blind_score.calibration import calibration
from fitting.blind_score.coverage import TIER, coverage
from fitting.blind_score.intervals import area, mean, quantile, share
from fitting.blind_score.judged import MISSING, NONE, PAIR, SINGLE, UNLISTED, Judged
from fitting.blind_score.limits import limits

STRONG = 3.0
"""The gap over the noise from which on an effect is called strong."""

NOTABLE_GAP = 1.1
"""Where held-out runs leave no more than so many times their floor there is nothing to close."""

MARGIN = 0.2
"""By so much a named effect should close more of the gap than the best that the records tell from it."""


def figures(cases: Sequence[Judged]) -> dict[str, Any]:
    """All figures of these cases, each with its 95 % interval."""
    single = _of_kind(cases, SINGLE)
    return {
        "cases": len(cases),
        **answers(cases),
        "calibration": calibration(cases),
        "coverage": coverage(cases),
        "closure": closure([case for case in single if case.gap >= STRONG]),
        "limits": limits(single),
    }


def answers(cases: Sequence[Judged]) -> dict[str, Any]:
    """The figures that follow from verdicts and probabilities alone."""
    single, pair = _of_kind(cases, SINGLE), _of_kind(cases, PAIR)
    free, strange = _of_kind(cases, NONE), _of_kind(cases, UNLISTED)
    listed = [*single, *pair]
    doubled = [case for case in single if len(case.same) > 1]
    strong, strange_strong = ([case for case in some if case.gap >= STRONG] for some in (single, strange))
    return {
        "right": share(case.right() for case in cases),
        "top1": share(case.right() for case in single),
        "top1_strong": share(case.right() for case in strong),
        "top2": share(case.second() for case in single),
        "probability": mean([case.probability() for case in single]),
        "probability_exact": mean([case.probability_exact() for case in single]),
        "family": share(case.family_right() for case in single),
        "none_called": share(case.right() for case in free),
        "false_alarms": share(case.verdict not in (NONE, UNLISTED) for case in free),
        "unlisted_called": share(case.right() for case in strange),
        "unlisted_called_strong": share(case.right() for case in strange_strong),
        "listed_called_unlisted": share(case.verdict in (UNLISTED, MISSING) for case in single),
        "auroc": area([_unlisted(case, 0.0) for case in strange], [_unlisted(case, 1.0) for case in listed]),
        "pairs_right": share(case.right() for case in pair),
        "pairs_both": share(case.both() for case in pair),
        "pairs_one": share(case.one() for case in pair),
        "pairs_third": share(case.third() or case.verdict == MISSING for case in pair),
        "aliases_as_class": share(case.as_class() for case in doubled),
        "aliases_alone": share(case.alone() for case in doubled),
    }


def closure(cases: Sequence[Judged]) -> dict[str, Any]:
    """How much of the reducible gap closes where nothing was fitted, for strong effects that were named, of
    those in which there is something to close.

    `placebo`: what an effect of no meaning closes; `margin`: the share of cases in which the named effect
    closes at least 0.2 more than the best that the records tell from it; `covered`: the share of intervals
    that hold all of the gap, in the tier whose effects are those of the catalogue, which close it.
    """
    named = [(case.tier, case.result["gap"]) for case in cases if case.right() and case.result is not None]
    named = [(tier, gap) for tier, gap in named if gap["before"] > NOTABLE_GAP * gap["floor"]]
    gaps = [gap for _, gap in named]
    closed = [gap["closed"] for gap in gaps if gap["closed"] is not None]
    placebo = [gap["placebo_closed"] for gap in gaps if gap.get("placebo_closed") is not None]
    beaten = [
        gap["closed"] - gap["best_wrong_closed"] >= MARGIN
        for gap in gaps
        if gap["closed"] is not None and gap.get("best_wrong_closed") is not None
    ]
    intervals = [gap["closed_interval"] for tier, gap in named if tier == TIER and gap["closed"] is not None]
    return {
        "median": quantile(closed, 0.5),
        "tenth": quantile(closed, 0.1),
        "placebo": quantile(placebo, 0.5),
        "margin": share(beaten),
        "covered": share(low <= 1.0 <= high for low, high in intervals),
    }


def _of_kind(cases: Sequence[Judged], kind: str) -> list[Judged]:
    return [case for case in cases if case.kind == kind]


def _unlisted(case: Judged, missing: float) -> float:
    """The probability of "unlisted"; the worst value where there is no diagnosis."""
    return missing if case.result is None else case.probabilities.get(UNLISTED, 0.0)
