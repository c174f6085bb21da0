"""Which effect: probabilities, the refitted candidates, which of them these records can tell apart, and what
they could have shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fitting.diagnosis.findings import Candidate, Diagnosis, Likeness, Limit, Parameter
from fitting.report.section import Bar, Number, Section, Subject
from fitting.report.words import (
    NONE,
    NOTHING,
    clamped,
    estimate,
    interval,
    is_number,
    number,
    percent,
    ranked,
    title,
    with_unit,
)

MOST_PROBABLE = 10
MOST_CANDIDATES = 8
MOST_PAIRS = 8
MOST_IN_MATRIX = 8


def which(subject: Subject) -> Section:
    """Probabilities, candidates, likeness, detection limits."""
    diagnosis = subject.diagnosis
    named = set(diagnosis.named) or {diagnosis.verdict}
    content = {
        "bars": [
            Bar(title(key, diagnosis.cards), percent(share), clamped(share), key in named, hint=key)
            for key, share in ranked(diagnosis.probabilities, MOST_PROBABLE)
        ],
        "others": max(len(diagnosis.probabilities) - MOST_PROBABLE, 0),
        "candidates": [_candidate(found, diagnosis) for found in diagnosis.candidates[:MOST_CANDIDATES]],
        "pairs": _pairs(diagnosis),
        "matrix": _matrix(diagnosis),
        "limits": _limits(diagnosis),
        "nothing": diagnosis.verdict == NONE,
    }
    return Section("which", "Which effect", "which.html", content)


def _candidate(found: Candidate, diagnosis: Diagnosis) -> dict[str, Any]:
    strength = found.parameters[0] if found.parameters else None
    unit = strength.unit if strength else "1"
    return {
        "title": " with ".join(title(key, diagnosis.cards) for key in found.keys),
        "names": " + ".join(found.keys),
        "named": bool(diagnosis.named) and set(found.keys) <= set(diagnosis.named),
        "probability": percent(found.probability),
        "closed": percent(found.closed),
        "misfit": number(found.misfit),
        "score": number(found.score),
        "strength": parameter_number(strength) if strength else Number(NOTHING),
        "limit": with_unit(number(found.detection_limit, 2), unit),
    }


def parameter_number(parameter: Parameter) -> Number:
    """An effect's parameter with its unit, and its interval."""
    ends = parameter.value, parameter.low, parameter.high
    return Number(with_unit(estimate(*ends), parameter.unit), with_unit(interval(*ends), parameter.unit))


def _pairs(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """The most alike pairs, those of the named effects first."""
    named = set(diagnosis.named)

    def order(pair: Likeness) -> tuple[bool, float]:
        return not named & {pair.one, pair.other}, -abs(pair.cosine)

    return [
        {
            "one": title(pair.one, diagnosis.cards),
            "other": title(pair.other, diagnosis.cards),
            "cosine": f"{pair.cosine:.2f}" if is_number(pair.cosine) else NOTHING,
            "length": clamped(abs(pair.cosine)),
            "separation": number(pair.separation),
        }
        for pair in sorted(diagnosis.likeness, key=order)[:MOST_PAIRS]
    ]


def _matrix(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """The cosines of the effects that occur in pairs, the named first; None where one pair says it all."""
    keys = _in_order(diagnosis.named, diagnosis.likeness)[:MOST_IN_MATRIX]
    if len(keys) < 3:
        return None
    known = {frozenset((pair.one, pair.other)): pair.cosine for pair in diagnosis.likeness}
    rows = []
    for row in keys:
        cells = []
        for column in keys:
            cosine = 1.0 if row == column else known.get(frozenset((row, column)))
            text = "" if cosine is None or not is_number(cosine) else f"{cosine:.2f}"
            cells.append({"text": text, "depth": clamped(None if cosine is None else abs(cosine))})
        rows.append({"title": title(row, diagnosis.cards), "cells": cells})
    return {"rows": rows}


def _limits(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """The detection limits, one row an effect."""
    by_effect: dict[str, list[Limit]] = {}
    for limit in diagnosis.limits:
        by_effect.setdefault(limit.effect, []).append(limit)
    return [
        {
            "title": title(key, diagnosis.cards),
            "name": key,
            "limits": [
                {"value": with_unit(number(limit.value, 2), limit.unit), "strength": limit.strength}
                for limit in own
            ],
            "likest": title(own[0].likest, diagnosis.cards) if own[0].likest else NOTHING,
            "cosine": "" if own[0].cosine is None else f"{own[0].cosine:.2f}",
        }
        for key, own in by_effect.items()
    ]


def _in_order(named: Sequence[str], likeness: Sequence[Likeness]) -> list[str]:
    """The effects that occur in pairs, each once: the named ones, then as they come."""
    present = dict.fromkeys(key for pair in likeness for key in (pair.one, pair.other))
    return [*(key for key in named if key in present), *(key for key in present if key not in named)]
