"""The diagnosis of a data set, from records to findings."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from fitting.account import joined
from fitting.correction import correction_of
from fitting.diagnosis.comparison import candidates, likeness
from fitting.diagnosis.findings import Diagnosis, Trace
from fitting.diagnosis.how_far.shrink import Split, split
from fitting.diagnosis.inquiry import Inquiry, inquire
from fitting.diagnosis.judging.verdict import NONE, UNLISTED
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.next_run import next_run
from fitting.diagnosis.noise.ground import Ground, ground
from fitting.diagnosis.noise.repeatability import wander_of
from fitting.diagnosis.refits.estimates import estimates
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import released
from fitting.diagnosis.refits.reported import reported
from fitting.diagnosis.settings import DiagnosisSettings
from fitting.diagnosis.unlisted.constancy import trend_of
from fitting.diagnosis.where.clue import clue_of
from fitting.diagnosis.where.localise import Seen, localise, residual_force, see
from fitting.diagnosis.where.pattern import patterns
from fitting.diagnosis.which.attribute import Attribution
from fitting.diagnosis.which.contacts import Chosen
from fitting.diagnosis.which.detection import limits
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.over_class import over_class
from fitting.diagnosis.which.shape_error import shape_variance
from fitting.diagnosis.words import advice, differing, notes, sentence, steps_taken
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
    with threadpool_limits(limits=1, user_api="blas"):
        return _diagnosed(dataset, settings or DiagnosisSettings(), progress or Silent())


def _diagnosed(dataset: DataSet, settings: DiagnosisSettings, progress: Progress) -> Diagnosis:
    """The diagnosis, whose own threads share the cores lane by lane and fit by fit: BLAS, whose threads would
    wait on one another within every small matrix, has one."""
    begun = time.perf_counter()
    held_out = settings.held_out(dataset)
    every = dataclasses.replace(
        dataset, runs=tuple(dataclasses.replace(run, hold_out=False) for run in dataset.runs)
    )
    fitting = Settings(seed=settings.seed, workers=settings.workers)
    problem = pose(every, fitting)
    model = Model(problem, settings.workers)
    base = ground(problem, model, fitting, progress, model.sharing.groups)
    inquiry = _inquired(Chosen(problem, model, base), held_out, settings, progress)
    chosen, bench, held = inquiry.chosen, inquiry.bench, inquiry.held
    problem, model, base = chosen.problem, chosen.model, chosen.ground
    progress.stage("everything fitted once more", 2)
    before, after = _finally(model, base, held, inquiry.found, inquiry.named)
    keys = tuple(model.shelf.effects) if inquiry.named is None else inquiry.named.keys
    inquiry = inquiry.disproved(trend_of(model, base.bench, after, keys))
    found, named, shrunk = inquiry.found, inquiry.named, inquiry.shrunk
    fine, after = reported(model, base.bench, before if named is None else after)
    before = after if named is None else before
    progress.advance()
    seen_before, seen_after = (see(model, base.bench, fit.point) for fit in (before, after))
    where = localise(problem, model, base.bench, base.segments, before, seen_before, found)
    force = residual_force(problem, base.segments, seen_before)
    unmended = mended = estimates(model, dataset, fine if named is None else base.bench, before)
    correction = None
    if named is not None:
        shape = shape_variance(found, named)[np.isin(named.refit.free, after.free)]
        mended = estimates(model, dataset, fine, after, named.keys, shape)
        mended = over_class(model, found, named, mended)
        if chosen.words is None:
            corrected = model.at(after.point.coordinates, after.point.acting(named.keys))
            correction = correction_of(corrected, dataset.rig)
    listed = candidates(model, found)
    progress.advance()
    judgement = found.judgement
    follows = {} if judgement.verdict == NONE else patterns(problem, model, base.bench, before.point)
    clue = clue_of(follows) if judgement.verdict == UNLISTED else None
    lead = next(iter(inquiry.anomalies), clue) if judgement.verdict == UNLISTED else None
    if lead is not None:
        where = dataclasses.replace(where, side=lead.sides or where.side)
    proposal = next_run(chosen, bench, found)
    return Diagnosis(
        verdict=judgement.verdict,
        named=judgement.named,
        probabilities=judgement.effects,
        sentence=sentence(model, judgement, shrunk, where, wander_of(found.nominal), inquiry.anomalies, clue),
        where=where,
        residual_force=force,
        follows=follows,
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
        next_experiment=advice(problem, model, found, bench, proposal, lead),
        next_run=proposal,
        notes=(
            *inquiry.doubts,
            *notes(problem, found, named, where, held, chosen, shrunk),
            *(anomaly.note for anomaly in inquiry.anomalies if anomaly.note is not None),
            *([clue.note] if clue is not None and inquiry.anomalies else []),
            *differing(mended.between_runs, len(problem.chosen)),
        ),
        steps=steps_taken(problem, model, found, base, held, chosen),
        sha256=dataset.sha256,
        settings=dataclasses.asdict(settings),
        seconds=time.perf_counter() - begun,
        correction=correction,
        limits=limits(model, found.screen, found.inflation),
        yardstick=found.yardstick,
    )


def _inquired(
    paper: Chosen, held_out: Sequence[str], settings: DiagnosisSettings, progress: Progress
) -> Inquiry:
    """The inquiry on the runs that are not held out. Where only those that are show a gap, or that something
    acts beside what is named, it is the one with others held out in their place, if that names something, or
    something else as well, and nobody asked for these to be held out."""
    problem, bench = paper.problem, paper.ground.bench
    held = split(problem, bench, held_out)
    inquiry = inquire(paper, held, settings.seed, progress)
    if not inquiry.is_doubted_there:
        return inquiry.qualified()
    if not held_out and not held.by_segments:
        other = inquire(paper, split(problem, bench, (), fitted=held.files), settings.seed, progress)
        if other.says_more_than(inquiry):
            return other
    return inquiry if inquiry.named else inquiry.unexplained()


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
                slide_rate=signal.slide_rate,
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
