"""Where, which, how far: three panels."""

from __future__ import annotations

from fitting.diagnosis.findings import Diagnosis
from fitting.report.section import Bar, Section, Subject
from fitting.report.words import (
    NONE,
    clamped,
    greatest,
    is_number,
    largest,
    listed,
    number,
    percent,
    ranked,
    share_interval,
    title,
)

LIKELIEST = 5


def summary(subject: Subject) -> Section:
    """The three panels."""
    diagnosis = subject.diagnosis
    content = {
        "where": _where(diagnosis),
        "which": _which(diagnosis),
        "how_far": _how_far(diagnosis),
        "next_experiment": diagnosis.next_experiment,
    }
    return Section("summary", "Summary", "summary.html", content)


def _where(diagnosis: Diagnosis) -> dict:
    where = diagnosis.where
    if diagnosis.verdict == NONE:
        return {"line": "Nowhere: what the fitted nominal model leaves is noise.", "groups": []}
    places, groups = [], []
    for name, words, shares in (
        ("Side", "on the side of", where.side),
        ("Phase of motion", "in", where.phase),
    ):
        top = largest(shares)
        if top is not None:
            places.append(f"{percent(top[1])} {words} {top[0]}")
        bars = [
            Bar(label, percent(share), clamped(share), strong=top is not None and label == top[0])
            for label, share in shares.items()
        ]
        groups.append((name, bars))
    return {"line": f"Of the excess over the noise, {listed(places)}.", "groups": groups}


def _which(diagnosis: Diagnosis) -> dict:
    named = set(diagnosis.named) or {diagnosis.verdict}
    bars = [
        Bar(title(key, diagnosis.cards), percent(share), clamped(share), key in named, hint=key)
        for key, share in ranked(diagnosis.probabilities, LIKELIEST)
    ]
    rest = 1 - sum(share for _, share in ranked(diagnosis.probabilities, LIKELIEST))
    return {"bars": bars, "rest": percent(max(rest, 0.0)), "others": len(diagnosis.probabilities) - len(bars)}


def _how_far(diagnosis: Diagnosis) -> dict:
    closure = diagnosis.closure
    steps = [
        ("assumed constants", closure.assumed, False),
        ("nominal, fitted", closure.before, False),
        ("with the effect", closure.after if diagnosis.effects else None, True),
        ("noise alone", closure.floor, False),
    ]
    top = greatest(value for _, value, _ in steps)
    bars = [
        Bar(label, number(value), clamped(value / top) if top else 0.0, strong)
        for label, value, strong in steps
        if value is not None and is_number(value)
    ]
    judged = listed(closure.held_out)
    if not judged:
        where = "stretches of the records that took no part"
    elif closure.by_segments:
        where = f"segments of {judged} that took no part"
    else:
        where = f"{judged}, which took no part"
    return {
        "closed": percent(closure.closed) if diagnosis.effects and is_number(closure.closed) else "",
        "interval": share_interval(*closure.interval),
        "bars": bars,
        "where": where,
    }
