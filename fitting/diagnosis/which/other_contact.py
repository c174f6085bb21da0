"""What was found on the paper's contact, found anew on the one that the records ask for."""

from __future__ import annotations

import dataclasses

from fitting.diagnosis.how_far.shrink import Split
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.which.attribute import Attribution, on_another_contact
from fitting.diagnosis.which.contacts import (
    WORTH_TRYING,
    Chosen,
    carried,
    choose_contact,
    concerns_contact,
)
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.survey import Survey, nominal_on, survey
from fitting.progress import Progress

SAME = 1.03
"""One effect on another contact takes the place of two that leave hardly less: so much do misfits differ by
chance."""
AS_MUCH = 0.5
"""A contact is tried in the place of an effect where it does at first so great a share of what that does."""
BESIDE = 2
"""With so many of the best explanations other contacts are tried, besides with the nominal model."""


def beside_single_effects(
    paper: Chosen, bench: Bench, seen: Survey, held: Split, progress: Progress
) -> tuple[Chosen, Survey]:
    """The contact that the records ask for, and the survey on it; the paper's contact where another neither
    explains clearly more, nor does without any effect what the best one does. Where an effect suffices, it
    must do that.
    """
    beside = [] if seen.suffices else seen.found[:BESIDE]
    fits = [seen.nominal, *(explanation.refit for explanation in beside)]
    worth = _worth(seen.nominal.misfit, seen.least)
    other = choose_contact(paper, bench, held.fitted, fits, seen.floor, progress, worth)
    if other.words is None:
        return paper, seen
    nominal = nominal_on(other.model, bench, other.ground.point.take(held.fitted))
    replaces = nominal.misfit < seen.least
    if seen.suffices and not replaces:
        return paper, seen
    known = [_moved(explanation, paper.model, other.model) for explanation in seen.found]
    again = survey(other.model, bench, nominal, other.ground.begins, progress, known)
    floor = min(seen.floor, again.floor)
    explains = again.least - floor < other.preferred * (seen.least - floor)
    return (other, again) if explains or replaces else (paper, seen)


def _worth(without: float, best: float) -> float:
    """Below which share of what lanes cost without an effect a contact is worth trying in the place of the
    best one, which leaves less than that by itself."""
    return max(WORTH_TRYING, 1 - AS_MUCH * (1 - best / without))


def _moved(found: Explanation, model: Model, other: Model) -> Explanation:
    """An explanation where it would begin under another contact; its misfit is still that under the first."""
    return found.fitted(carried(found.refit, model, other))


def in_place_of_one_of_two(
    paper: Chosen, bench: Bench, found: Attribution, held: Split, progress: Progress
) -> tuple[Chosen, Attribution]:
    """Where one of the two effects that explain the records best changes the contact: the contact on which
    the other one alone explains them as well; the paper's where there is none."""
    model, best = paper.model, found.explanations[0]
    others = tuple(key for key in best.keys if not concerns_contact(model, [key]))
    alone = [e for e in found.explanations if e.keys == others]
    if len(best.keys) != 2 or len(others) != 1 or not alone:
        return paper, found
    fit, two = alone[0].refit, best.refit.misfit
    worth = _worth(fit.misfit, two)
    other = choose_contact(paper, bench, held.fitted, [fit], found.floor, progress, worth)
    if other.words is None:
        return paper, found
    beside = [e for e in found.explanations if e.keys != others]
    again = on_another_contact(
        model, bench, dataclasses.replace(found, explanations=(alone[0], *beside)), other.model
    )
    left = min(e.refit.misfit for e in again.explanations if e.keys == others)
    return (other, again) if left < SAME * two else (paper, found)


def beside_a_pair(
    paper: Chosen, bench: Bench, found: Attribution, held: Split, progress: Progress
) -> tuple[Chosen, Attribution]:
    """The contact that the records ask for beside the best pair, and what explains them on it; the paper's
    where another does not leave clearly less."""
    best = found.explanations[0].refit
    other = choose_contact(paper, bench, held.fitted, [best], found.floor, progress)
    if other.words is None:
        return paper, found
    again = on_another_contact(paper.model, bench, found, other.model)
    floor = min(found.floor, again.floor)
    left = again.explanations[0].refit.misfit - floor
    return (other, again) if left < other.preferred * (best.misfit - floor) else (paper, found)
