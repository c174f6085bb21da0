"""The diagnosis of a data set, from records to findings."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Sequence

import numpy as np

from fitting.account import joined
from fitting.correction import correction_of
from fitting.diagnosis.attribute import Attribution, attribute, on_another_contact
from fitting.diagnosis.confidence import deviations
from fitting.diagnosis.contacts import Chosen, choose_contact, concerns_contact
from fitting.diagnosis.contest import Explanation
from fitting.diagnosis.detection import detection_limit, limits
from fitting.diagnosis.findings import Candidate, Diagnosis, Likeness, Parameter, Trace
from fitting.diagnosis.ground import Ground, ground, resolved
from fitting.diagnosis.judge import refuted
from fitting.diagnosis.localise import Seen, localise, residual_force, see
from fitting.diagnosis.model import RIG_TOLERANCE, Model
from fitting.diagnosis.refit import Bench, Point, Refit, refit
from fitting.diagnosis.release import released
from fitting.diagnosis.settings import DiagnosisSettings
from fitting.diagnosis.shrink import (
    Split,
    check_hold_out,
    closure,
    left_open,
    part,
    refutes,
    share_closed,
    split,
)
from fitting.diagnosis.survey import Survey, survey
from fitting.diagnosis.words import advice, notes, refutation, sentence, steps_taken
from fitting.problem import Problem, pose
from fitting.progress import Progress, Silent
from fitting.result import Constant
from fitting.segments import Segment
from fitting.settings import Settings
from fitting.unknowns import RIG
from jaxstick.record import CONSTANTS, DataSet

BESIDE = 2
"""With so many of the best explanations other contacts are tried, besides with the nominal model."""
ALIKE = 8
"""How many of the best explanations are compared with one another."""


def diagnose(
    dataset: DataSet,
    settings: DiagnosisSettings | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Says where simulation and records part, which effect causes it, and how far the gap then shrinks.

    The nominal model is fitted, every effect of the shelf is tried on the runs that are not held out, and the
    shrinking is measured on those that are.

    Raises UserError for records or settings that do not allow a diagnosis, before anything long is computed.
    """
    begun = time.perf_counter()
    settings = settings or DiagnosisSettings()
    progress = progress or Silent()
    held_out = tuple(dict.fromkeys((*settings.hold_out, *(run.file for run in dataset.runs if run.hold_out))))
    check_hold_out([run.file for run in dataset.runs], held_out)
    every = dataclasses.replace(
        dataset, runs=tuple(dataclasses.replace(run, hold_out=False) for run in dataset.runs)
    )
    fitting = Settings(seed=settings.seed, workers=settings.workers)
    problem = pose(every, fitting)
    model = Model(problem, settings.workers)
    base = ground(problem, model, fitting, progress)
    held = split(problem, base.bench, held_out)
    begin = part(base.point, held.fitted)
    bench = resolved(model, base.bench.take(held.fitted), begin)
    seen = survey(model, bench, begin, progress)
    chosen = Chosen(problem, model, base)
    if not seen.suffices or concerns_contact(model, seen.found[0].keys):
        chosen, seen = _on_another_contact(chosen, bench, seen, held, settings.workers, progress)
        problem, model, base = chosen.problem, chosen.model, chosen.ground
    found = attribute(model, bench, seen, progress)
    if chosen.words is None and found.asks_for_a_contact:
        chosen, found = _beside_a_pair(chosen, bench, found, held, settings.workers, progress)
        problem, model, base = chosen.problem, chosen.model, chosen.ground
    named = _named(found)
    progress.stage("how far the gap shrinks", 3)
    shrunk = closure(problem, model, base.bench, held, _fits(found, named), base.point.own, settings.seed)
    progress.advance()
    doubts: tuple[str, ...] = ()
    if named is not None and refutes(shrunk):
        doubts = (refutation(named.keys, shrunk),)
        found, named = dataclasses.replace(found, judgement=refuted(found.judgement)), None
        shrunk = left_open(shrunk)
    before, after = _finally(model, base, held, found, named)
    progress.advance()
    seen_before, seen_after = (see(model, base.bench, fit.point) for fit in (before, after))
    where = localise(problem, model, base.bench, base.segments, before, seen_before, found)
    force = residual_force(problem, base.segments, seen_before)
    spread = deviations(model, base.bench, before)
    constants_before, others_before = _constants(model, dataset, before, *spread)
    constants, others, effects, correction = constants_before, others_before, {}, None
    if named is not None:
        spread = deviations(model, base.bench, after)
        constants, others = _constants(model, dataset, after, *spread)
        effects = _effects(model, after, named.keys, *spread)
        if chosen.words is None:
            correction = correction_of(model.at(after.point.coordinates, named.keys), dataset.rig)
    candidates = _candidates(model, found)
    progress.advance()
    judgement = found.judgement
    mentioned = dict.fromkeys((*judgement.named, *(key for c in candidates[:4] for key in c.keys)))
    return Diagnosis(
        verdict=judgement.verdict,
        named=judgement.named,
        probabilities=judgement.effects,
        sentence=sentence(model, judgement, shrunk, where),
        where=where,
        residual_force=force,
        candidates=candidates,
        likeness=_likeness(found, bench),
        closure=shrunk,
        effects=effects,
        constants=constants,
        constants_before=constants_before,
        others=others,
        others_before=others_before,
        traces=_traces(problem, base.segments, held, seen_before, seen_after),
        cards={key: model.shelf.effects[key].card for key in mentioned},
        next_experiment=advice(problem, model, found, bench),
        notes=(*doubts, *notes(problem, found, where, held, chosen)),
        steps=steps_taken(problem, model, found, base, held, chosen),
        sha256=dataset.sha256,
        settings=dataclasses.asdict(settings),
        seconds=time.perf_counter() - begun,
        correction=correction,
        limits=limits(model, found.screen, found.inflation),
    )


def _on_another_contact(
    paper: Chosen, bench: Bench, seen: Survey, held: Split, workers: int, progress: Progress
) -> tuple[Chosen, Survey]:
    """The contact that the records ask for, and the survey on it; the paper's contact where another does not
    explain clearly more. Where an effect suffices, another contact must do without any what that effect does.
    """
    problem, model, base = paper.problem, paper.model, paper.ground
    beside = [] if seen.suffices else seen.found[:BESIDE]
    fits = [seen.nominal, *(explanation.refit for explanation in beside)]
    other = choose_contact(problem, model, base, bench, held.fitted, fits, seen.floor, workers, progress)
    if other.words is None:
        return paper, seen
    again = survey(other.model, bench, part(other.ground.point, held.fitted), progress)
    if seen.suffices:
        explains = again.nominal.misfit < seen.least
    else:
        floor = min(seen.floor, again.floor)
        explains = again.least - floor < other.preferred * (seen.least - floor)
    return (other, again) if explains else (paper, seen)


def _beside_a_pair(
    paper: Chosen, bench: Bench, found: Attribution, held: Split, workers: int, progress: Progress
) -> tuple[Chosen, Attribution]:
    """The contact that the records ask for beside the best pair, and what explains them on it; the paper's
    where another does not leave clearly less."""
    best = found.explanations[0].refit
    other = choose_contact(
        paper.problem, paper.model, paper.ground, bench, held.fitted, [best], found.floor, workers, progress
    )
    if other.words is None:
        return paper, found
    again = on_another_contact(paper.model, bench, found, other.model)
    floor = min(found.floor, again.floor)
    left = again.explanations[0].refit.misfit - floor
    return (other, again) if left < other.preferred * (best.misfit - floor) else (paper, found)


def _named(found: Attribution) -> Explanation | None:
    """The explanation that the verdict rests on, the likeliest of what it names; None for nothing named."""
    named = found.judgement.named
    if not named:
        return None
    wanted = set(named) if found.judgement.verdict == "several" else {named[0]}
    return next(e for e in found.explanations if set(e.keys) == wanted)


def _fits(found: Attribution, named: Explanation | None) -> dict[str, Refit]:
    """The fits whose gaps are compared on what was held out."""
    fits = {"nominal": found.nominal, "named": found.nominal if named is None else named.refit}
    mentioned = set(found.judgement.named)
    wrong = [e for e in found.explanations if not mentioned & set(e.keys)]
    if wrong and mentioned:
        fits["wrong"] = wrong[0].refit
        fits["placebo"] = wrong[-1].refit
    return fits


def _finally(
    model: Model, base: Ground, held: Split, found: Attribution, named: Explanation | None
) -> tuple[Refit, Refit]:
    """The nominal model and the named explanation, each fitted once more to everything there is."""

    def begin(fit: Refit) -> Point:
        own = base.point.own.copy()
        own[held.fitted] = fit.point.own
        return dataclasses.replace(fit.point, own=own)

    chosen = [found.nominal] if named is None else [found.nominal, named.refit]
    results = refit(model, base.bench, [begin(fit) for fit in chosen], [fit.free for fit in chosen])
    nominal, *others = model.side_by_side(lambda fit: released(model, base.bench, fit), results)
    return nominal, others[-1] if others else nominal


def _constants(
    model: Model, dataset: DataSet, fit: Refit, spread: np.ndarray, quantile: float
) -> tuple[tuple[Constant, ...], tuple[Constant, ...]]:
    """The constants of friction, and the properties of the rig that were free within their tolerance."""
    stated = {name: getattr(dataset.assumed, name) for name in CONSTANTS}
    stated |= {f"{RIG}{name}": getattr(dataset.rig, name) for name in RIG_TOLERANCE}
    found = []
    for index, deviation in zip(fit.free.tolist(), spread.tolist(), strict=True):
        name = model.names[index]
        if name not in stated:
            continue
        value, low, high = _bounds(model, fit, index, deviation, quantile)
        found.append(
            Constant(
                name=name,
                value=value,
                low=low,
                high=high,
                unit=model.members[index].unit,
                assumed=stated[name],
                standard_error=None if low is None or high is None else (high - low) / (2 * quantile),
                method="covariance",
            )
        )
    friction = tuple(constant for constant in found if constant.name in CONSTANTS)
    return friction, tuple(constant for constant in found if constant.name not in CONSTANTS)


def _effects(
    model: Model, fit: Refit, keys: Sequence[str], spread: np.ndarray, quantile: float
) -> dict[str, tuple[Parameter, ...]]:
    deviation = dict(zip(fit.free.tolist(), spread.tolist(), strict=True))
    out = {}
    for key in keys:
        own = []
        for index in model.of(key).tolist():
            if index not in deviation:
                continue
            value, low, high = _bounds(model, fit, index, deviation[index], quantile)
            name = model.names[index].partition(".")[2]
            own.append(Parameter(name, value, low, high, model.members[index].unit))
        out[key] = tuple(own)
    return out


def _bounds(
    model: Model, fit: Refit, index: int, deviation: float, quantile: float
) -> tuple[float, float | None, float | None]:
    """A parameter's value and 95 % interval in its own unit; an end beyond the bounds is no end."""
    member, at = model.members[index], float(fit.point.coordinates[index])
    low, high = at - quantile * deviation, at + quantile * deviation
    return (
        float(member.to_value(at)),
        float(member.to_value(low)) if low > model.lower[index] and math.isfinite(low) else None,
        float(member.to_value(high)) if high < model.upper[index] and math.isfinite(high) else None,
    )


def _candidates(model: Model, found: Attribution) -> tuple[Candidate, ...]:
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


def _likeness(found: Attribution, bench: Bench) -> tuple[Likeness, ...]:
    """Every two of the best single explanations: how alike they are and how far apart their misfits."""
    singles = [e for e in found.explanations if len(e.keys) == 1][:ALIKE]
    place = {key: number for number, key in enumerate(found.screen.keys)}
    out = []
    for number, one in enumerate(singles):
        for other in singles[number + 1 :]:
            difference = other.refit.cost - one.refit.cost
            spread = float(np.std(difference)) * math.sqrt(len(difference))
            out.append(
                Likeness(
                    one.keys[0],
                    other.keys[0],
                    float(found.screen.cosine[place[one.keys[0]], place[other.keys[0]]]),
                    float(difference.sum()) / max(spread, 1e-300),
                )
            )
    return tuple(out)


def _traces(
    problem: Problem, segments: Sequence[Segment], held: Split, before: Seen, after: Seen
) -> tuple[Trace, ...]:
    motions = (joined(segments, seen.read_displacement, seen.read_friction) for seen in (before, after))
    out = []
    for signal, first, last in zip(problem.chosen, *motions, strict=True):
        run = signal.run
        out.append(
            Trace(
                file=run.file,
                held_out=run.file in held.files,
                time=run.time,
                base=signal.base,
                velocity=signal.velocity,
                displacement=run.displacement,
                friction=run.friction,
                before_displacement=first[0],
                before_friction=first[1],
                after_displacement=last[0],
                after_friction=last[1],
                displacement_noise=signal.displacement_noise,
                friction_noise=signal.friction_noise,
            )
        )
    return tuple(out)
