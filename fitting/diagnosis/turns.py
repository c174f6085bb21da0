"""What explains the records, on which contact, and what of them does not repeat itself, found in turns: a
wrong contact, or an effect that is missing, overrates that, and what is overrated hides both."""

from __future__ import annotations

import dataclasses

import numpy as np

from fitting.diagnosis.how_far.elsewhere import in_place
from fitting.diagnosis.how_far.shrink import Split
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.ground import resolved
from fitting.diagnosis.noise.repeatability import floor_of
from fitting.diagnosis.noise.scatter import Scatter
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.which.another_time import in_another_time
from fitting.diagnosis.which.attribute import Attribution, attribute, on_another_bench, with_pairs_anew
from fitting.diagnosis.which.contacts import Chosen, concerns_contact
from fitting.diagnosis.which.explanation import best_of, fitted_again
from fitting.diagnosis.which.other_contact import beside_single_effects
from fitting.diagnosis.which.survey import NOTABLE, Survey, nominal_on, survey
from fitting.progress import Progress

TURNS = 3
MOSTLY = 0.4
"""Residuals are weighed by what does not repeat itself before anything else is tried where that is a larger
share of the nominal model's misfit."""
OVERRATED = 0.8
"""Where an explanation leaves less, what does not repeat itself has been taken for more than it is; it is
found anew, in so many turns at most."""


def surveyed(
    paper: Chosen, plain: Bench, begin: Point, held: Split, progress: Progress
) -> tuple[Chosen, Bench, Survey]:
    """The contact that the records ask for, the bench of what is not held out, weighed by what does not
    repeat itself where that is notable, and the survey there. `paper`, `plain`: the assumed contact, and the
    bench as it was laid out; `begin`: the nominal model there."""
    chosen, bench, seen = _first(paper, plain, begin, held, progress)
    for _ in range(TURNS):
        if seen.scatters or _overrated(bench, seen):
            best = seen.found[0].refit.point
            chosen, bench = _evened(chosen, paper.ground.bench, plain, held, best)
            point, known = seen.nominal.point, seen.found
            nominal = nominal_on(chosen.model, bench, point)
            seen = survey(chosen.model, bench, nominal, paper.ground.begins, progress, known)
        if chosen.words is None and _may_be_the_contact(chosen, bench, seen):
            chosen, seen = beside_single_effects(chosen, bench, seen, held, progress)
        if not _overrated(bench, seen):
            break
    return chosen, bench, seen


def _first(
    paper: Chosen, plain: Bench, begin: Point, held: Split, progress: Progress
) -> tuple[Chosen, Bench, Survey]:
    """The first survey: on the bench as it was laid out, or weighed at once by what does not repeat itself
    where that is a good part of what the nominal model leaves, and is notable under what is found then, too:
    what keeps another time than the excitation does not repeat itself either, until it is in the model,
    alone or beside what was found. Where what is found so leads nowhere it is sought in units of the noise
    as well, and found where all repeats itself once it is in the model: a table that rings through stick and
    slip does not come to rest between two cycles."""
    model, begins = paper.model, paper.ground.begins
    nominal, known = nominal_on(model, plain, begin), ()
    if floor_of(model, plain, [nominal]) > max(NOTABLE, MOSTLY * nominal.misfit):
        chosen, bench = _evened(paper, paper.ground.bench, plain, held, nominal.point)
        seen = survey(model, bench, nominal_on(model, bench, nominal.point), begins, progress)
        (best,) = fitted_again(model, plain, seen.found[:1])
        known = seen.found
        if floor_of(model, plain, [best.refit]) > NOTABLE:
            two = in_another_time(model, plain, best, seen.screen.shapes, progress)
            if two is None:
                if seen.leads:
                    return chosen, bench, seen
                unweighed = survey(model, plain, nominal, begins, progress, known)
                return (chosen, bench, seen) if unweighed.scatters else (paper, plain, unweighed)
            known = two, best
    seen = survey(model, plain, nominal, begins, progress, known)
    return paper, plain, _with_another_time(model, plain, seen, progress)


def _with_another_time(model: Model, plain: Bench, seen: Survey, progress: Progress) -> Survey:
    """The survey with what keeps another time beside its best effect, where a good deal does not repeat
    itself under that."""
    best = seen.found[0]
    if not seen.scatters or len(best.keys) > 1:
        return seen
    two = in_another_time(model, plain, best, seen.screen.shapes, progress)
    if two is None:
        return seen
    floor = min(seen.floor, floor_of(model, plain, [two.refit]))
    return dataclasses.replace(seen, found=tuple(best_of([two, *seen.found])), floor=floor)


def weighed_anew(
    paper: Chosen, chosen: Chosen, bench: Bench, plain: Bench, held: Split, found: Attribution
) -> tuple[Chosen, Bench, Attribution]:
    """The choice, the bench and what explains the records there, with what does not repeat itself found anew
    where two effects leave less than that."""
    for _ in range(TURNS):
        best = found.explanations[0].refit
        if not bench.scatters or best.misfit >= OVERRATED:
            break
        chosen, bench, found = _by_what_is_left(paper, chosen, plain, held, found, best)
    return chosen, bench, found


def less_scattered(
    paper: Chosen,
    chosen: Chosen,
    bench: Bench,
    plain: Bench,
    held: Split,
    found: Attribution,
    progress: Progress,
) -> tuple[Chosen, Bench, Attribution]:
    """The choice, the bench and what explains the records there, where less does not repeat itself under the
    best explanation, fitted to residuals in units of the noise, than was taken for it: what a wrong model
    leaves is not the same in every cycle where the motion is not, and in units of that it hides what acts
    besides. All are weighed anew by what is left of it, pairs are sought where nothing known suffices there,
    and all weighed once more where another leads then, or where it is overrated still; or, where it is hardly
    more than the noise, all are sought anew in units of the noise."""
    taken = chosen.ground.scatter
    if not bench.scatters or taken is None:
        return chosen, bench, found
    model, best = chosen.model, found.explanations[0].refit
    (best,) = refit(model, plain, [best.point], [best.free])
    if floor_of(model, plain, [best]) <= NOTABLE:
        ground = dataclasses.replace(chosen.ground, bench=paper.ground.bench, scatter=None)
        found = _sought_anew(model, plain, paper.ground.begins, found, progress)
        return dataclasses.replace(chosen, ground=ground), plain, found
    if taken.exceeds(Scatter.of(model, plain, best.point, chosen.problem.period)):
        chosen, bench, known = _by_what_is_left(paper, chosen, plain, held, found, best)
        found = with_pairs_anew(model, bench, known, progress)
        leader = found.explanations[0]
        if leader.keys != known.explanations[0].keys:
            chosen, bench, found = _by_what_is_left(paper, chosen, plain, held, found, leader.refit)
        return weighed_anew(paper, chosen, bench, plain, held, found)
    return chosen, bench, found


def _by_what_is_left(
    paper: Chosen, chosen: Chosen, plain: Bench, held: Split, found: Attribution, best: Refit
) -> tuple[Chosen, Bench, Attribution]:
    """The choice, the bench and what explains the records, weighed anew by what does not repeat itself under
    this fit."""
    chosen, bench = _evened(chosen, paper.ground.bench, plain, held, best.point)
    return chosen, bench, on_another_bench(chosen.model, bench, found)


def _sought_anew(
    model: Model, bench: Bench, begins: np.ndarray, found: Attribution, progress: Progress
) -> Attribution:
    """What explains the records on another bench, sought from the beginning on and from what is known."""
    known = fitted_again(model, bench, found.leading)
    nominal = nominal_on(model, bench, found.nominal.point)
    seen = survey(model, bench, nominal, begins, progress)
    singles = best_of([*seen.found, *(e for e in known if len(e.keys) == 1)])
    floor = min(seen.floor, floor_of(model, bench, [nominal, *(e.refit for e in known)]))
    seen = dataclasses.replace(seen, found=tuple(singles), floor=floor)
    return attribute(model, bench, seen, progress, [e for e in known if len(e.keys) > 1])


def _may_be_the_contact(chosen: Chosen, bench: Bench, seen: Survey) -> bool:
    """Whether another contact may explain more than is explained, or do what an effect does: where friction
    scatters, one that is hardly seen in what is left bends the levels of friction, as effects do."""
    return not seen.suffices or bench.scatters or concerns_contact(chosen.model, seen.found[0].keys)


def _overrated(bench: Bench, seen: Survey) -> bool:
    return bench.scatters and seen.least < OVERRATED


def _evened(chosen: Chosen, every: Bench, plain: Bench, held: Split, best: Point) -> tuple[Chosen, Bench]:
    """The choice with its ground, and the bench of what is not held out, both weighed by what does not repeat
    itself under the best explanation of that bench so far; `every` and `plain` are they as laid out. That
    bench has no more integration steps than residuals weighed so can tell. What is held out starts in the
    ground as it does under that explanation."""
    model = chosen.model
    scatter = Scatter.of(model, plain, best, chosen.problem.period)
    ground = chosen.ground
    point = in_place(model, every, best.among(ground.point.own, held.fitted), held.held)
    whole = scatter.evened(model, every, point)
    begin = ground.point.take(held.fitted).among(point.own, held.fitted)
    ground = dataclasses.replace(ground, bench=whole, point=begin, scatter=scatter)
    evened = resolved(model, scatter.evened(model, plain, best), best)
    return dataclasses.replace(chosen, ground=ground), evened
