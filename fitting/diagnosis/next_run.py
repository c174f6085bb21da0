"""The run that would tell two explanations apart.

Of runs that differ from the recorded ones in frequency and amplitude that one is proposed in which, were
either explanation true, the other would leave the most once all that it has free is fitted to that run and to
the records there are (T-optimality: Atkinson, Fedorov, Biometrika 62 (1975) 57; what is free moves as far as
the linearised model says, and of the two cases the one counts that leaves less).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.findings import TELLING, Plan, Proposal
from fitting.diagnosis.judging.judge import pieces_of_evidence
from fitting.diagnosis.judging.single import AMONG
from fitting.diagnosis.judging.verdict import alternatives
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.laying import lay_whole
from fitting.diagnosis.lanes.layout import Layout
from fitting.diagnosis.lanes.model import LEVEL_TOLERANCE, Model
from fitting.diagnosis.planned import plans, recorded
from fitting.diagnosis.refits.confidence import Scores, information, scores
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.refits.release import settled
from fitting.diagnosis.which.attribute import Attribution
from fitting.diagnosis.which.contacts import Chosen
from fitting.diagnosis.which.explanation import Explanation
from fitting.problem import Problem
from jaxstick.errors import UserError

LANES = 10
"""So many segments stand for a run, spread evenly over it."""
LOST = 4.0
"""A segment that costs so many times as much as the typical one of its run has lost an event, and says
nothing."""


def next_run(chosen: Chosen, bench: Bench, found: Attribution) -> Proposal | None:
    """The run that would tell the two explanations apart that a verdict leaves open (`rivals`), fitted on
    this bench; None where it leaves none open, where no sine drives the rig, and where the contact is too
    stiff for so many runs to be simulated."""
    two = rivals(found)
    if two is None or not (tried := plans(chosen.problem)):
        return None
    one, other = two
    unit = _unit(found, one)
    try:
        either = [
            left(chosen, bench, tried, true.refit, rival.refit)
            for true, rival in ((one, other), (other, one))
        ]
    except UserError:
        return None
    gained = np.minimum(*either) / unit
    best = int(np.argmax(gained))
    known = max(float(np.sum(other.refit.cost - one.refit.cost)), 0.0) / unit
    times = max(1, math.ceil((TELLING**2 - known) / max(float(gained[best]), 1e-9)))
    separation = math.sqrt(known + times * float(gained[best]))
    return Proposal(tried[best], times, separation, math.sqrt(known))


def rivals(found: Attribution) -> tuple[Explanation, Explanation] | None:
    """The two explanations that a verdict leaves open, the likelier first: the first two effects of those
    that cannot be told apart, or two effects and what is as likely with another in the place of one of them.
    None where nothing is open, where no record could tell them apart, and where one was not refitted."""
    judgement = found.judgement
    if judgement.same or judgement.verdict not in ("ambiguous", "several"):
        return None
    if judgement.verdict == "ambiguous":
        one, other = ({name} for name in judgement.named[:2])
    else:
        one = {*judgement.taken}
        instead = alternatives(judgement.explanations, judgement.taken)
        other = next((one - {gone} | {key} for key, gone in instead.items()), set[str]())
    refitted = {frozenset(e.keys): e for e in found.explanations}
    pair = refitted.get(frozenset(one)), refitted.get(frozenset(other))
    return None if pair[0] is None or pair[1] is None else (pair[0], pair[1])


def _unit(found: Attribution, best: Explanation) -> float:
    """How much of chi-square is one independent piece of evidence, as explanations are judged."""
    against = found.yardstick
    least = max(best.refit.misfit / against.floor, 1.0)
    pieces = pieces_of_evidence(least, against.samples, AMONG)
    return least * against.samples / pieces


def _laid(problem: Problem, substeps: int) -> tuple[Bench, np.ndarray]:
    """The runs of a problem as a bench of a few lanes each, and for how many lanes each of these stands."""
    whole = lay_whole(problem, substeps)
    of_runs = [np.flatnonzero(whole.run == number) for number in range(whole.runs)]
    bench = whole.take(np.concatenate([mine[whole.take(mine).spread(LANES)] for mine in of_runs]))
    return bench, (np.bincount(whole.run) / np.bincount(bench.run))[bench.run]


def left(chosen: Chosen, bench: Bench, tried: Sequence[Plan], true: Refit, rival: Refit) -> np.ndarray:
    """How much a rival, fitted on the bench, leaves of every planned run (chi-square), were another fit true,
    once what it has free has followed that run as far as the bench lets it."""
    records = recorded(chosen.problem, chosen.model, true, tried)
    problem = dataclasses.replace(chosen.problem, signals=records, chosen=records)
    planned, stands_for = _laid(problem, bench.lanes.substeps)
    model, scatter = chosen.model, chosen.ground.scatter
    typical = rival.point.by_run[np.unique(bench.run)].mean(0)
    typical[0] = 0.0
    point = dataclasses.replace(
        rival.point, by_run=np.tile(typical, (planned.runs, 1)), own=np.asarray(planned.lanes.start)
    )
    point = dataclasses.replace(point, own=settled(model, planned, point).own)
    if scatter is not None:
        planned = scatter.evened(model, planned, point)
    seen = scores(model, planned, point, rival.free)
    held = _held(model, bench, rival)
    return np.array(
        [
            _once_followed(seen, np.flatnonzero(planned.run == number), planned.dof(), stands_for, held)
            for number in range(planned.runs)
        ]
    )


def _once_followed(
    seen: Scores, lanes: np.ndarray, dof: np.ndarray, stands_for: np.ndarray, held: np.ndarray
) -> float:
    """What the lanes of one run still cost once level and free unknowns, held by `held`, have followed them:
    r'r - r'J (J'J + held)^-1 J'r."""
    share = np.nan_to_num(seen.cost[lanes] / dof[lanes] + 1.0, nan=np.inf)
    lanes = lanes[share < LOST * np.median(share)]
    weight = stands_for[lanes]
    pull, curvature = weight @ seen.gradient[lanes], np.einsum("l,lcd->cd", weight, seen.curvature[lanes])
    followed = pull @ np.linalg.solve(curvature + held, pull)
    return max(float(np.nan_to_num(weight @ seen.cost[lanes] - followed)), 0.0)


def _held(model: Model, bench: Bench, fit: Refit) -> np.ndarray:
    """How closely level and free unknowns are held in another run (curvature of chi-square/2): what all runs
    share by the bench, what every run has of its own by its prior."""
    of_run = np.concatenate([[True], np.isin(fit.free, model.by_run)])
    _, _, prior = model.prior(fit.point.coordinates[fit.free], fit.free)
    held = np.diag(np.concatenate([[LEVEL_TOLERANCE**-2.0], prior]))
    held[np.ix_(~of_run, ~of_run)] = _known(model, bench, fit)
    return held


def _known(model: Model, bench: Bench, fit: Refit) -> np.ndarray:
    """What a bench tells of the unknowns that all its runs share, whatever every run has of its own."""
    layout = Layout.of(model, bench, fit.free)
    shared = slice(0, len(layout.shared))
    return np.linalg.inv(np.linalg.inv(information(model, bench, fit))[shared, shared])
