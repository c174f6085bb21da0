"""Judgements reconsidered once more is known than what they rest on."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from fitting.diagnosis.judging.judgement import DOUBT, Judgement, judged, reserve
from fitting.diagnosis.judging.verdict import NONE, UNLISTED

NEXT_TO_NOTHING = 1e-9
"""What is left to "unlisted" where everything else is taken back."""
REFUTED = 0.1
"""The share of its probability that an effect keeps when what took no part speaks against it."""
SUCCEEDED = 0.05
"""The share that it keeps when that speaks for another effect, too."""


def weighed_again(
    judgement: Judgement, keys: tuple[str, ...], steadier: float, others: Mapping[tuple[str, ...], float] = {}
) -> Judgement:
    """The judgement once runs that took no part have said by how much steadier an explanation makes friction
    there, and maybe some `others` (logarithms of likelihood ratios). What these were credited with for that
    is at most doubled or taken back, and what all others were in the same proportion as that of the first.
    Effects that were not refitted have no part in it: theirs is what is kept for what nobody thought of."""

    def proportion(keys: tuple[str, ...], steadier: float) -> float:
        own = judgement.steadier[keys]
        return float(np.clip(steadier / own, -1.0, 1.0)) if own > 0 else 0.0

    usual = proportion(keys, steadier)
    known = {each: proportion(each, its) for each, its in others.items()}
    kept = reserve(judgement.explanations)
    tried = {NONE, UNLISTED, *("+".join(each) for each in judgement.steadier)}
    weights = {
        name: max(p - kept[name], 0.0) if name in tried else 0.0 for name, p in judgement.explanations.items()
    }
    weights[UNLISTED] += NEXT_TO_NOTHING
    for each, worth in judgement.steadier.items():
        weights["+".join(each) or UNLISTED] *= math.exp(known.get(each, usual) * worth)
    whole = sum(weights.values())
    explanations = {name: kept[name] + (1 - DOUBT) * weight / whole for name, weight in weights.items()}
    return judged(explanations, judgement.effects, judgement.steadier, judgement.classes)


def refuted(judgement: Judgement, heir: str = UNLISTED) -> Judgement:
    """The judgement once runs that took no part have spoken against the effects that it names: what was
    likely of effects is so of the heir, "unlisted" or "none", but for a tenth."""
    explanations = {
        name: p if name in (NONE, UNLISTED) else REFUTED * p for name, p in judgement.explanations.items()
    }
    explanations[heir] += 1 - sum(explanations.values())
    return judged(explanations, judgement.effects, judgement.steadier, judgement.classes)


def succeeded(judgement: Judgement, keys: tuple[str, ...], heir: tuple[str, ...]) -> Judgement:
    """The judgement once runs that took no part have spoken against one explanation, and for another: what
    was likely of the former is so of the latter, but for a twentieth."""
    return _handed_on(judgement, "+".join(keys), "+".join(heir), SUCCEEDED)


def astray(judgement: Judgement) -> Judgement:
    """The judgement where segments go astray although the rest shows no gap, or scatter more than friction
    that wanders can: whatever acts in these, it is not nothing. What was likely of "none" is so of
    "unlisted", but for a tenth."""
    return _handed_on(judgement, NONE, UNLISTED, REFUTED)


def _handed_on(judgement: Judgement, name: str, heir: str, kept: float) -> Judgement:
    """The judgement where what is likely of one explanation is so of another, but for the share `kept`."""
    explanations = dict(judgement.explanations)
    rest = (1 - kept) * explanations[name]
    explanations[name] -= rest
    explanations[heir] += rest
    return judged(explanations, judgement.effects, judgement.steadier, judgement.classes)
