"""The explanations side by side, as a report lists them."""

from __future__ import annotations

import math

from fitting.diagnosis.findings import Candidate, Likeness, Parameter
from fitting.diagnosis.how_far.shrink import share_closed
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.which.attribute import Attribution
from fitting.diagnosis.which.detection import detection_limit
from fitting.diagnosis.which.explanation import separation

ALIKE = 8
"""How many of the best explanations are compared with one another."""


def candidates(model: Model, found: Attribution) -> tuple[Candidate, ...]:
    """Every explanation with its parameters and what it closes of the gap, the likeliest first."""
    before = math.sqrt(found.nominal.misfit)
    out = []
    for explanation in found.explanations:
        fit, promise = explanation.refit, explanation.promise
        free = set(fit.free.tolist())
        own = [i for key in explanation.keys for i in model.of(key) if i in free]
        out.append(
            Candidate(
                keys=explanation.keys,
                score=promise.score,
                misfit=fit.misfit,
                closed=share_closed(before, math.sqrt(fit.misfit), min(1.0, before)),
                probability=found.judgement.explanations["+".join(explanation.keys)],
                parameters=tuple(
                    Parameter(
                        model.names[i] if len(explanation.keys) > 1 else model.names[i].partition(".")[2],
                        float(model.members[i].to_value(fit.point.coordinates[i])),
                        None,
                        None,
                        model.members[i].unit,
                    )
                    for i in own
                ),
                detection_limit=detection_limit(model, promise, found.inflation),
            )
        )
    return tuple(sorted(out, key=lambda candidate: -candidate.probability))


def likeness(found: Attribution, bench: Bench) -> tuple[Likeness, ...]:
    """Every two of the best single explanations: how alike they are and how far apart their misfits."""
    singles = [e for e in found.explanations if len(e.keys) == 1][:ALIKE]
    place = {key: number for number, key in enumerate(found.screen.keys)}
    out = []
    for number, one in enumerate(singles):
        for other in singles[number + 1 :]:
            out.append(
                Likeness(
                    one.keys[0],
                    other.keys[0],
                    float(found.screen.cosine[place[one.keys[0]], place[other.keys[0]]]),
                    separation(one, other),
                )
            )
    return tuple(out)
