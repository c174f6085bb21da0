"""The verdict that probabilities of explanations come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fitting.diagnosis.findings import Verdict
from fitting.diagnosis.judging.one_class import Classes

ENOUGH = 0.9
NOTABLE = 0.1
AS_LIKELY = 0.9
"""An effect is named beside two that act together where in the place of one of them it is at least so many
times as likely."""
MOST_NAMED = 4
TOLD_APART = 2
"""Against "unlisted", or two effects at work, so many single effects stand together, each with its class: an
answer that leaves the choice between more is none."""

NONE, UNLISTED = "none", "unlisted"


def verdict_of(
    explanations: Mapping[str, float], classes: Classes | None = None
) -> tuple[Verdict, tuple[str, ...]]:
    """The verdict that probabilities of explanations come to, and the effects that it names; effects of one
    of the `classes`, which no record tells apart, are one answer."""
    leader = max(explanations, key=lambda name: explanations[name])
    singles = {
        name: p for name, p in explanations.items() if name not in (NONE, UNLISTED) and "+" not in name
    }
    answers: dict[frozenset[str], float] = {}
    for name, p in singles.items():
        answer = frozenset((name, *(classes or {}).get((name,), ())))
        answers[answer] = answers.get(answer, 0.0) + p
    rivals = sorted(answers.values(), reverse=True)
    together = sum(rivals if leader == NONE else rivals[:TOLD_APART])
    if leader not in singles and together > explanations[leader]:
        leader = max(singles, key=lambda name: singles[name])
    if leader == NONE:
        return "none", ()
    if leader == UNLISTED:
        return "unlisted", ()
    if "+" in leader:
        pair = leader.split("+")
        return "several", (*pair, *alternatives(explanations, pair))
    named, covered = [], 0.0
    for name in sorted(singles, key=lambda name: -singles[name]):
        if covered > ENOUGH * sum(singles.values()) or singles[name] < NOTABLE * singles[leader]:
            break
        named.append(name)
        covered += singles[name]
    named = named[:MOST_NAMED]
    return ("effect" if len(named) == 1 else "ambiguous"), tuple(named)


def alternatives(explanations: Mapping[str, float], pair: Sequence[str]) -> dict[str, str]:
    """What may act in the place of one of two effects that act together, the likeliest first, with the one
    whose place it takes."""
    likely = AS_LIKELY * explanations["+".join(pair)]
    found = {}
    for name in sorted(explanations, key=lambda name: -explanations[name]):
        keys = set(name.split("+"))
        if len(keys) == 2 and len(keys & {*pair}) == 1 and explanations[name] > likely:
            ((other,), (gone,)) = keys - {*pair}, {*pair} - keys
            found.setdefault(other, gone)
    return found
