"""The diagnosis of a data set, from records to findings."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence

from fitting.account import joined
from fitting.correction import correction_of
from fitting.diagnosis.attribute import Attribution, attribute
from fitting.diagnosis.comparison import candidates, likeness
from fitting.diagnosis.contacts import Chosen
from fitting.diagnosis.detection import limits
from fitting.diagnosis.estimates import estimates
from fitting.diagnosis.explanation import Explanation
from fitting.diagnosis.findings import Closure, Diagnosis, Trace
from fitting.diagnosis.ground import Ground, ground, resolved
from fitting.diagnosis.judge import Judgement, astray, refuted, weighed_again
from fitting.diagnosis.localise import Seen, localise, residual_force, see
from fitting.diagnosis.model import Model
from fitting.diagnosis.next_run import next_run
from fitting.diagnosis.other_contact import beside_a_pair, in_place_of_one_of_two
from fitting.diagnosis.refit import Refit, refit
from fitting.diagnosis.release import released
from fitting.diagnosis.repeatability import wander_of
from fitting.diagnosis.scatter import restless
from fitting.diagnosis.settings import DiagnosisSettings
from fitting.diagnosis.shrink import (
    CLEARLY,
    ONLY_HERE,
    Split,
    closure,
    gain,
    left_open,
    refutes,
    split,
    stays_open,
    steadies,
    worsens,
)
from fitting.diagnosis.turns import surveyed, weighed_anew
from fitting.diagnosis.verdict import NONE, UNLISTED
from fitting.diagnosis.words import advice, notes, refutation, sentence, steps_taken
from fitting.problem import Problem, pose
from fitting.progress import Progress, Silent
from fitting.segments import Segment
from fitting.settings import Settings
from jaxstick.record import DataSet


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
    held_out = settings.held_out(dataset)
    every = dataclasses.replace(
        dataset, runs=tuple(dataclasses.replace(run, hold_out=False) for run in dataset.runs)
    )
    fitting = Settings(seed=settings.seed, workers=settings.workers)
    problem = pose(every, fitting)
    model = Model(problem, settings.workers)
    base = ground(problem, model, fitting, progress, model.groups())
    held = split(problem, base.bench, held_out)
    begin = base.point.take(held.fitted)
    plain = resolved(model, base.bench.take(held.fitted), begin)
    paper = Chosen(problem, model, base)
    chosen, bench, seen = surveyed(paper, plain, begin, held, progress)
    found = attribute(chosen.model, bench, seen, progress)
    chosen, bench, found = weighed_anew(paper, chosen, bench, plain, held, found)
    if chosen.words is None and found.asks_for_a_contact:
        chosen, found = beside_a_pair(chosen, bench, found, held, progress)
    if chosen.words is None:
        chosen, found = in_place_of_one_of_two(chosen, bench, found, held, progress)
    problem, model, base = chosen.problem, chosen.model, chosen.ground
    unsteady = found.judgement.verdict == "none" and restless(problem, model, found.nominal, base.scatter)
    if unsteady:
        found = dataclasses.replace(found, judgement=astray(found.judgement))
    named = _named(found)
    progress.stage("how far the gap shrinks", 3)
    shrunk = _shrunk(chosen, held, found, named, settings.seed)
    progress.advance()
    doubts: tuple[str, ...] = ()
    if named is not None:
        found = dataclasses.replace(found, judgement=confirmed(found, named, shrunk))
        first, named = named, _named(found)
        if named is None:
            doubts = (refutation(first.keys, shrunk),)
            shrunk = left_open(shrunk)
        elif named is not first:
            shrunk = _shrunk(chosen, held, found, named, settings.seed)
    before, after = _finally(model, base, held, found, named)
    progress.advance()
    seen_before, seen_after = (see(model, base.bench, fit.point) for fit in (before, after))
    where = localise(problem, model, base.bench, base.segments, before, seen_before, found)
    force = residual_force(problem, base.segments, seen_before)
    unmended = mended = estimates(model, dataset, base.bench, before)
    correction = None
    if named is not None:
        mended = estimates(model, dataset, base.bench, after, named.keys)
        if chosen.words is None:
            correction = correction_of(model.at(after.point.coordinates, named.keys), dataset.rig)
    listed = candidates(model, found)
    progress.advance()
    judgement = found.judgement
    proposal = next_run(chosen, bench, found)
    return Diagnosis(
        verdict=judgement.verdict,
        named=judgement.named,
        probabilities=judgement.effects,
        sentence=sentence(model, judgement, shrunk, where, wander_of(found.nominal), restless=unsteady),
        where=where,
        residual_force=force,
        candidates=listed,
        likeness=likeness(found, bench),
        closure=shrunk,
        effects=mended.effects,
        constants=mended.constants,
        constants_before=unmended.constants,
        others=mended.others,
        others_before=unmended.others,
        traces=_traces(problem, base.segments, held, seen_before, seen_after),
        cards={key: effect.card for key, effect in model.shelf.effects.items()},
        next_experiment=advice(problem, model, found, bench, proposal),
        next_run=proposal,
        notes=(*doubts, *notes(problem, found, named, where, held, chosen, shrunk)),
        steps=steps_taken(problem, model, found, base, held, chosen),
        sha256=dataset.sha256,
        settings=dataclasses.asdict(settings),
        seconds=time.perf_counter() - begun,
        correction=correction,
        limits=limits(model, found.screen, found.inflation),
        yardstick=found.yardstick,
    )


def _named(found: Attribution) -> Explanation | None:
    """The explanation that the verdict rests on, the likeliest of what it names; None for nothing named."""
    taken = set(found.judgement.taken)
    return next(e for e in found.explanations if set(e.keys) == taken) if taken else None


def confirmed(found: Attribution, named: Explanation, shrunk: Closure) -> Judgement:
    """The judgement once runs that took no part have spoken for or against what is named.

    An effect that is named since it makes friction steadier, where there is no gap, explains what runs show
    that took no part, too, if it explains anything.
    """
    judgement = weighed_again(found.judgement, named.keys, shrunk.steadier)
    if not judgement.named:
        return judgement
    if steadies(shrunk, judgement.steadier[named.keys]):
        no_cause = found.shows_no_gap and stays_open(shrunk, ONLY_HERE)
        return refuted(judgement, NONE) if no_cause else judgement
    if refutes(shrunk, gain(found.nominal, named.refit)):
        return refuted(judgement, UNLISTED)
    if found.shows_no_gap:
        return refuted(judgement, NONE) if worsens(shrunk) else judgement
    return refuted(judgement, UNLISTED) if worsens(shrunk, CLEARLY) else judgement


def _shrunk(chosen: Chosen, held: Split, found: Attribution, named: Explanation | None, seed: int) -> Closure:
    """How far the gap shrinks on what was held out."""
    base, fits = chosen.ground, _fits(found, named)
    return closure(chosen.problem, chosen.model, base.bench, held, fits, base.point.own, seed)


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

    chosen = [found.nominal] if named is None else [found.nominal, named.refit]
    begin = [fit.point.among(base.point.own, held.fitted) for fit in chosen]
    results = refit(model, base.bench, begin, [fit.free for fit in chosen])
    nominal, *others = model.side_by_side(lambda fit: released(model, base.bench, fit), results)
    return nominal, others[-1] if others else nominal


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
