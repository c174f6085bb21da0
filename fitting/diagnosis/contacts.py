"""Which contact: the paper's, or one that gives way gradually, where no single effect explains the records.

How a contact yields is a property of every pair of surfaces, no fault of the rig: a bristle under the wrong
name would make every effect look unlikely. The contact is chosen on the nominal model, and all effects are
then tried on the one chosen.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.ground import Ground
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import Bench, Point, Refit, refit
from fitting.diagnosis.release import released
from fitting.problem import Problem
from jaxstick.parts.contact import AbstractContact
from jaxstick.parts.gradual import ElastoPlasticContact, IwanContact, LuGreContact

PREFERRED = 0.6
"""Another contact is taken only if lanes cost less than this share of what they do, on the mean;"""
PREFERRED_WIDER = 0.85
"""or this one, if the paper's is a case of it."""
STEPS = 8


@dataclasses.dataclass(frozen=True)
class Chosen:
    """A problem with the contact chosen, its model, and the ground carried over to it. `words` say which
    contact it is, None for the paper's; `ratio` is the mean ratio of the lanes' costs to those under it."""

    problem: Problem
    model: Model
    ground: Ground
    words: str | None
    ratio: float


@dataclasses.dataclass(frozen=True)
class Rival:
    """A contact that is tried besides the paper's: what a report calls it, and the share of what lanes cost
    under the paper's below which it is taken."""

    words: str
    contact: AbstractContact
    preferred: float


def gradual_contacts(k1: float) -> tuple[Rival, ...]:
    """The contacts that give way gradually."""
    return (
        Rival("an elasto-plastic bristle", ElastoPlasticContact(k1), PREFERRED),
        Rival("a bristle that gives way from the first on (LuGre)", LuGreContact(k1), PREFERRED),
        Rival("elements that yield one after another (Iwan)", IwanContact(k1), PREFERRED_WIDER),
    )


def concerns_contact(model: Model, keys: Sequence[str]) -> bool:
    """Whether one of these effects changes the contact itself."""
    nominal = model.nominal
    return any(model.effect(key).attach(nominal).contact is not nominal.contact for key in keys)


def choose_contact(
    problem: Problem,
    model: Model,
    ground: Ground,
    bench: Bench,
    lanes: np.ndarray,
    nominal: Refit,
    workers: int,
) -> Chosen:
    """The contact that the records ask for, judged by the mean ratio of the lanes' costs on a bench that has
    some `lanes` of the ground, and beginning at the nominal model's refit there."""
    parts = problem.hypothesis.nominal
    (paper,) = refit(model, bench, [nominal.point], [model.nuisances()], iterations=STEPS)
    best, least = Chosen(problem, model, ground, None, 1.0), 1.0
    for rival in gradual_contacts(float(np.asarray(parts.contact.k1))):
        hypothesis = dataclasses.replace(
            problem.hypothesis, nominal=dataclasses.replace(parts, contact=rival.contact)
        )
        other = dataclasses.replace(problem, hypothesis=hypothesis)
        its = Model(other, workers)
        (found,) = refit(its, bench, [carried(paper.point, model, its)], [its.nuisances()], iterations=STEPS)
        if _ratio(found, paper) < 1:
            found = released(its, bench, found)
        ratio = _ratio(found, paper)
        if ratio < min(least, rival.preferred):
            own = ground.point.own.copy()
            own[lanes] = found.point.own
            point = dataclasses.replace(found.point, own=own, widths=ground.point.widths)
            moved = dataclasses.replace(ground, point=point)
            best, least = Chosen(other, its, moved, rival.words, ratio), ratio
    return best


def _ratio(fit: Refit, paper: Refit) -> float:
    """The mean ratio of the lanes' costs, which a few lost lanes do not decide."""
    return float(np.exp(np.mean(np.log(fit.cost / paper.cost))))


def carried(point: Point, model: Model, other: Model) -> Point:
    """A nominal point of one model as one of another; what only the other has is at its typical value."""
    coordinates = other.origin({})
    shared = [name for name in model.common if name in other.common]
    coordinates[other.index(*shared)] = point.coordinates[model.index(*shared)]
    return dataclasses.replace(point, coordinates=coordinates)
