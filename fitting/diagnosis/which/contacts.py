"""Which contact: the paper's, or one that gives way gradually, where no single effect explains the records.

How a contact yields is a property of every pair of surfaces, no fault of the rig: a bristle under the wrong
name would make every effect look unlikely. The contact is chosen on the nominal model and on the effects that
lead, for a strong effect hides what the contact does; all effects are then tried on the one chosen.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.ground import Ground, sought
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import all_settled, released
from fitting.problem import Problem
from fitting.progress import Progress, Silent
from jaxstick.parts.contact import AbstractContact
from jaxstick.parts.gradual import ElastoPlasticContact, IwanContact, LuGreContact

WORTH_TRYING = 0.85
"""A contact is worth a survey if lanes cost less than this share of what they do under the paper's, or if it
leaves less than this share of the excess over the floor: where friction scatters, the floor is most of what
lanes cost."""
PREFERRED = 0.6
"""It is taken if the survey then leaves less than this share of the excess over the floor that it leaves on
the paper's,"""
PREFERRED_WIDER = 0.85
"""or this one, if the paper's is a case of it."""
STEPS = 8
NOTABLE = 0.1
"""An excess of no more than this share of the floor is none that a contact could be told by."""
HOPEFUL = 2.0
"""Lost lanes are looked after under a contact unless lanes cost more than so many times what they do."""


@dataclasses.dataclass(frozen=True)
class Chosen:
    """A problem with the contact chosen, its model, and the ground carried over to it. `words` say which
    contact it is, None for the paper's; `ratio` is the mean ratio of the lanes' costs to those under it, the
    lowest there is for a hypothesis that was tried on both; `preferred` the share of the excess that the
    contact must not leave."""

    problem: Problem
    model: Model
    ground: Ground
    words: str | None = None
    ratio: float = 1.0
    preferred: float = 1.0


@dataclasses.dataclass(frozen=True)
class Rival:
    """A contact that is tried besides the paper's: what a report calls it, and the share of the excess
    below which it is taken."""

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
    paper: Chosen,
    bench: Bench,
    lanes: np.ndarray,
    fits: Sequence[Refit],
    floor: float,
    progress: Progress,
    worth: float = WORTH_TRYING,
) -> Chosen:
    """The contact that the records may ask for, on a bench that has some `lanes` of the ground.

    Every contact is tried on each of the fits under the `paper`'s: the nominal model's, and those of effects
    that may act beside it. The nominal model is also begun at constants that are sought under the contact
    itself, for the best ones under the paper's may lie in a valley of their own. Of the contacts that are
    `worth` trying, `floor` being the misfit that no model gets below, the one on which lanes cost least is
    chosen.
    """
    problem, model, ground = paper.problem, paper.model, paper.ground
    parts = problem.hypothesis.nominal
    progress.stage("contacts tried", 1)
    before = refit(model, bench, [fit.point for fit in fits], [fit.free for fit in fits], iterations=STEPS)

    def tried(rival: Rival) -> tuple[float, Chosen] | None:
        """What lanes cost under a rival, and the choice of it; None where it is not worth a survey."""
        hypothesis = dataclasses.replace(
            problem.hypothesis, nominal=dataclasses.replace(parts, contact=rival.contact)
        )
        other = dataclasses.replace(problem, hypothesis=hypothesis)
        its = Model(other, model.workers)
        begins = _begun(before, model, its, bench, ground)
        points, free = [begun.point for begun, _ in begins], [begun.free for begun, _ in begins]
        found = refit(its, bench, points, free, iterations=STEPS)
        pairs = [(fit, same) for fit, (_, same) in zip(found, begins, strict=True)]
        one, same = min(pairs, key=lambda pair: _typical(pair[0]))
        if _ratio(one, same) < HOPEFUL:
            one = released(its, bench, one)
            pairs.append((one, same))
        ratio = min(_ratio(*pair) for pair in pairs)
        if not min(ratio, *(_left(*pair, floor) for pair in pairs)) < worth:
            return None
        alone = one.point.without(its, its.shelf.effects).among(ground.point.own, lanes)
        point = dataclasses.replace(alone, keys=(), widths=ground.point.widths)
        moved = dataclasses.replace(ground, point=point)
        return _typical(one), Chosen(other, its, moved, rival.words, ratio, rival.preferred)

    rivals = gradual_contacts(float(np.asarray(parts.contact.k1)))
    worthy = [each for each in model.side_by_side(tried, rivals) if each is not None]
    chosen = min(worthy, key=lambda each: each[0])[1] if worthy else paper
    progress.advance(chosen.words or "the assumed one stays")
    return chosen


def _begun(
    fits: Sequence[Refit], model: Model, other: Model, bench: Bench, ground: Ground
) -> list[tuple[Refit, Refit]]:
    """Where the fits under one contact would begin under another, each beside its fit: as carried over, and
    the nominal model's also at the constants that a search under the other contact finds, every lane settled
    there."""
    begins = []
    for fit in fits:
        begun = carried(fit, model, other)
        begins.append((begun, fit))
        if not other.free_effects(begun.free):
            constants = sought(other, ground.shortest, ground.begins, Silent())
            points = [begun.point.at_constants(other, values) for values in constants]
            begins += [(begun.begun(point, begun.free), fit) for point in all_settled(other, bench, points)]
    return begins


def _typical(fit: Refit) -> float:
    """The mean of the lanes' logarithmic costs, which a few lost lanes do not decide."""
    return float(np.mean(np.log(fit.cost)))


def _ratio(fit: Refit, paper: Refit) -> float:
    """The mean ratio of the lanes' costs."""
    return math.exp(_typical(fit) - _typical(paper))


def _left(fit: Refit, paper: Refit, floor: float) -> float:
    """The share of the excess over the floor that is left; 1 where there is hardly any."""
    excess = paper.misfit - floor
    return (fit.misfit - floor) / excess if excess > NOTABLE * floor else 1.0


def carried(fit: Refit, model: Model, other: Model) -> Refit:
    """Where a refit under one model would begin under another: what only the other has is at its typical
    value, and no more effects are attached than the fit has, for programs are new there. Free is what is so
    there under every hypothesis, and the unknowns of the fit's effects. Cost and misfit are still those
    under the first."""
    coordinates = other.origin({})
    shared = [name for name in model.names if name in other.names]
    coordinates[other.index(*shared)] = fit.point.coordinates[model.index(*shared)]
    attached = other.sharing.together(model.free_effects(fit.free))
    own = [model.names[i] for i in fit.free if model.names[i] not in model.common]
    free = np.concatenate([other.nuisances(), other.index(*own)])
    return fit.begun(dataclasses.replace(fit.point, coordinates=coordinates, keys=attached), free)
