"""The diagnosis in sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from fitting.diagnosis.findings import MOST_TIMES, Closure, Proposal, Where
from fitting.diagnosis.how_far.shrink import LEAST_REDUCIBLE, NOTABLE_STEADINESS, Split, shows_more
from fitting.diagnosis.judging.enough import passes_for_noise
from fitting.diagnosis.judging.judgement import Judgement
from fitting.diagnosis.judging.verdict import alternatives
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.next_run import rivals
from fitting.diagnosis.noise.ground import Ground
from fitting.diagnosis.noise.repeatability import wander_of
from fitting.diagnosis.noise.scatter import Scatter
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly
from fitting.diagnosis.where.clue import Clue
from fitting.diagnosis.which.attribute import LOST, Attribution
from fitting.diagnosis.which.contacts import Chosen
from fitting.diagnosis.which.explanation import Explanation
from fitting.problem import Problem

WEAK = 3.0
NOTABLE_WANDER, STILLER = 0.5, 0.6
"""Friction that wanders by more than this many percent; and by less than this share of that."""
LITTLE = 0.03
"""A smaller share of the gap is nothing."""
SAME_GAP = 0.01
"""Gaps that differ by less than this share of them are the same."""
LEFT_OVER = 1.5
"""A misfit of more than so many times the floor is more than noise."""
DIFFERS = 0.01
"""The share of itself by which friction has to differ from run to run to be worth a word."""
MUCH = 1.0
"""Friction that wanders by more than so many percent is part of the verdict."""


def sentence(
    model: Model,
    judgement: Judgement,
    shrunk: Closure,
    where: Where,
    wander: float = 0.0,
    anomalies: Sequence[AbstractAnomaly] = (),
    clue: Clue | None = None,
) -> str:
    """The verdict in one sentence. `wander`: by how many percent friction wanders under the nominal model;
    `anomalies`: what is seen that no effect does, the plainest first; `clue`: what the gap follows."""
    titles = [model.shelf.titled(key) for key in judgement.named]
    if judgement.verdict == "none":
        far = f", if friction may wander by {wander:.2g} % from segment to segment" if wander > MUCH else ""
        return (
            f"The records agree with the simulator within their noise{far}: no effect on the shelf is called "
            "for."
        )
    if judgement.verdict == "unlisted" and anomalies:
        return f"No effect on the shelf explains the records: {anomalies[0].clause}."
    if judgement.verdict == "unlisted":
        share = ", ".join(f"{100 * v:.0f} % in {name}" for name, v in _largest(where.phase, 2))
        known = f"; it lies {share}" if clue is None else f": {clue.clause}"
        times = f"{shrunk.before:.3g} times the noise"
        return f"No effect on the shelf explains the gap, which is {times}{known}."
    if judgement.verdict == "effect":
        p = judgement.effects[judgement.named[0]]
        closes = _closing(shrunk, judgement, "it closes")
        return f"The gap comes from {titles[0]}, with probability {p:.2f}; {closes}."
    if judgement.verdict == "several":
        known = {key for same in judgement.same for key in same}
        instead = "".join(
            f"; in the place of {other} these records would have {model.shelf.titled(key)} as well"
            for key, other in alternatives(judgement.explanations, judgement.taken).items()
            if key not in known
        )
        instead += "".join(
            f"; no record tells {key} from {_listed(others, 'or')}" for key, *others in judgement.same
        )
        closes = _closing(shrunk, judgement, "together they close")
        return f"{' and '.join(titles[:2])} act together; {closes}{instead}."
    closes = _closing(shrunk, judgement, "the likeliest closes")
    return f"These records cannot tell {', '.join(titles[:-1])} from {titles[-1]}; {closes}."


def _closing(shrunk: Closure, judgement: Judgement, closes: str) -> str:
    """How much is closed, or why nothing is: there may be nothing to close, where friction that may wander
    takes over what an effect does to it."""
    where = f"on {_held(shrunk)} that took no part"
    if shrunk.closed > LITTLE:
        return f"{closes} {100 * shrunk.closed:.0f} % of the reducible gap {where}"
    hidden = judgement.steadier.get(judgement.taken, 0.0) > NOTABLE_STEADINESS
    why = ", since friction that may wander takes over what is missing" if hidden else ""
    if shrunk.before - shrunk.floor < LEAST_REDUCIBLE:
        return f"{where} there is no gap to be closed{why}"
    return f"{closes} nothing of the gap {where}{why}"


def _held(shrunk: Closure) -> str:
    return "segments" if shrunk.by_segments else "runs"


def refutation(named: Sequence[str], shrunk: Closure) -> str:
    """Why what explains the fitted records best is not named."""
    held = _held(shrunk)
    if shrunk.steadier < 0 and abs(shrunk.after - shrunk.before) < SAME_GAP * shrunk.before:
        return (
            f"{' with '.join(named)} makes friction steadier from segment to segment in the {held} that were "
            "fitted, but not in those that took no part, and closes no gap: that may be chance."
        )
    return (
        f"{' with '.join(named)} explains the {held} that were fitted best, but on those that took no part "
        f"the gap is {shrunk.after:.3g} times the noise with it and {shrunk.before:.3g} without: "
        "it is not the cause."
    )


def only_there(shrunk: Closure) -> str:
    """What is to be known where nothing is found in what was fitted, and what took no part shows a gap."""
    apart = f" ({', '.join(shrunk.held_out)})" if shrunk.held_out else ""
    return (
        f"The {_held(shrunk)} that were fitted agree with the simulator, but on those that took no part"
        f"{apart} the gap is {shrunk.before:.3g} times the noise: something acts there that the others do "
        "not show."
    )


def few_there(shrunk: Closure) -> str:
    """What is to be known where nothing is found, and next to all that took no part agrees with that."""
    return (
        f"On {_held(shrunk)} that took no part the gap is {shrunk.before:.3g} times the noise, but so few of "
        "their segments show it that it may be chance: from a start near the limit of friction a mass may as "
        "well slip as stick."
    )


def _listed(keys: Sequence[str], last: str = "and") -> str:
    return f" {last} ".join(filter(None, (", ".join(keys[:-1]), keys[-1])))


def _largest(parts: Mapping[str, float], count: int) -> list[tuple[str, float]]:
    return sorted(parts.items(), key=lambda part: -part[1])[:count]


def advice(
    problem: Problem,
    model: Model,
    found: Attribution,
    bench: Bench,
    proposal: Proposal | None,
    lead: AbstractAnomaly | Clue | None = None,
) -> str | None:
    """The experiment that would tell the two likeliest explanations apart, or where to look for what none of
    the shelf explains; None where nothing is in doubt. `proposal`: the run that would, where one was looked
    for; `lead`: what is to be gone by where nothing is named."""
    judgement = found.judgement
    if judgement.verdict == "none":
        return None
    if judgement.verdict == "unlisted" and lead is not None:
        return lead.look
    if judgement.same:
        remedies = dict.fromkeys(
            model.shelf.effects[key].card.remedy for s in judgement.same for key in s[:2]
        )
        apart = ", nor ".join(_listed(same) for same in judgement.same)
        return f"No record of the motion tells {apart} apart. {' '.join(remedies)}"
    remedy = model.shelf.effects[judgement.named[0]].card.remedy if judgement.named else ""
    open_ones = rivals(found)
    if proposal is not None and open_ones is not None:
        one, other = (" with ".join(e.keys) for e in open_ones)
        return f"{proposed(proposal, one, other)}; {remedy[:1].lower()}{remedy[1:]}"
    if judgement.verdict in ("effect", "several"):
        return remedy
    singles = [e for e in found.explanations if len(e.keys) == 1]
    if len(singles) < 2:
        return None
    one, other = open_ones or (singles[0], singles[1])
    difference = np.abs(other.refit.cost - one.refit.cost) / np.maximum(bench.dof(), 1)
    by_run = {n: float(difference[bench.run == n].mean()) for n in np.unique(bench.run)}
    run = problem.chosen[max(by_run, key=lambda n: by_run[n])].run
    regime = run.file + (f" ({run.frequency:.3g} Hz)" if run.frequency else "")
    first, second = one.keys[0], other.keys[0]
    return (
        f"{first} and {second} differ most in the regime of {regime}: record it again, "
        f"longer and at twice the amplitude; {model.shelf.effects[first].card.remedy}"
    )


def proposed(proposal: Proposal, one: str, other: str) -> str:
    """The run that would tell two explanations apart, or that none would."""
    if not proposal.tells:
        return (
            f"No run of other frequency or amplitude near the recorded ones, nor up to {MOST_TIMES} times as "
            f"long, would tell {one} from {other}"
        )
    plan, times = proposal.plan, proposal.times
    size = f"{plan.amplitude:.3g} N of force" if plan.by_force else f"{1e3 * plan.amplitude:.3g} mm of base"
    long = "as long as those recorded" if times == 1 else f"{times} times as long as those recorded"
    return (
        f"A run at {plan.frequency:.3g} Hz with {size} amplitude, {long}, would set {one} and {other} "
        f"{proposal.separation:.2g} standard deviations apart ({proposal.so_far:.2g} so far)"
    )


def notes(
    problem: Problem,
    found: Attribution,
    named: Explanation | None,
    where: Where,
    held: Split,
    contact: Chosen,
    shrunk: Closure,
) -> tuple[str, ...]:
    """What weakens the verdict, and what has to be known to read it."""
    out = []
    silent = all(signal.run.friction is None for signal in problem.chosen)
    scatter = contact.ground.scatter
    if silent:
        out.append(
            "There is no friction channel: faults of the mechanics and of the friction law can imitate one "
            "another, faults of the force measurement cannot be seen, and friction that wanders "
            f"{'is part of the gap' if scatter is None else 'is told by the motion alone'}."
        )
    if contact.words is not None:
        out.append(
            f"The contact was taken for {contact.words}, since the stick-slip contact of the assumptions "
            f"leaves {1 / contact.ratio:.3g} times as much; a rig file cannot hold that, so none was written."
        )
    if scatter is not None:
        out += scattering(scatter, silent)
    if held.by_segments:
        out.append(
            "Too few runs to hold any out: the shrinking was measured on every third stretch of the runs "
            "that were fitted, so nothing is said about other frequencies."
        )
    for same in found.judgement.same:
        out.append(
            f"{_listed(same)} leave the same trace in any record of the motion: they are answered together, "
            "and intervals of constants hold what these are under each of them. What is stated of the rig, "
            "and nothing that was recorded, makes the first the likeliest."
        )
    out += of_every_run(contact.model, problem.chosen[0].run.file, found.judgement.named)
    if named is not None:
        out += stiller(named.keys, wander_of(found.nominal), wander_of(named.refit))
        out += in_turn([key for key in named.refit.point.turned[::-1] if key in named.keys])
    if found.lost > LOST:
        out.append(f"{100 * found.lost:.0f} % of the segments fit far worse than the rest and count little.")
    if 0 < where.significance < WEAK and found.judgement.verdict != "none":
        out.append(
            f"The gap stands only {where.significance:.1f} standard deviations above the noise, "
            "counted by segments."
        )
    return (*out, *remainders(found, named, shrunk))


def remainders(found: Attribution, named: Explanation | None, shrunk: Closure) -> list[str]:
    """What is to be known where something is left beside what is named: in the records that were fitted or,
    where nothing is left there, in those that took no part."""
    if named is None:
        return []
    best = min(e.refit.misfit for e in found.explanations) / found.floor
    why = "something else acts as well, or the effect has another shape than on the shelf."
    if best > LEFT_OVER:
        return [f"What is named leaves a misfit of {best:.3g} times what no model can get below: {why}"]
    if passes_for_noise(named.refit.misfit / found.floor) and shows_more(shrunk):
        return [
            f"What is named leaves next to nothing where it was fitted, but on {_held(shrunk)} that took no "
            f"part {shrunk.after / shrunk.floor:.3g} times what no model can get below: {why}"
        ]
    return []


def stiller(named: Sequence[str], before: float, after: float) -> list[str]:
    """What is to be known where friction wanders far less with what is named, by so many percent."""
    if before < NOTABLE_WANDER or after > STILLER * before:
        return []
    return [
        f"Friction wanders from segment to segment by {after:.2g} % (standard deviation) with "
        f"{' and '.join(named)}, by {before:.2g} % without: what wandering takes over of an effect is no "
        "part of the gap, nor of the share of it that closes."
    ]


def in_turn(links: Sequence[str]) -> list[str]:
    """What is to be known of two links of the measuring chain that leave less in this order."""
    if len(links) < 2:
        return []
    first, then = links
    return [
        f"On its way to the record the signal passes {first} first and then {then}: the other way round the "
        "two explain it less well."
    ]


def differing(between_runs: float, runs: int) -> list[str]:
    """That friction differs from run to run, where it does by a good deal, and what that means."""
    if between_runs < DIFFERS:
        return []
    return [
        f"Friction differs from run to run by {100 * between_runs:.2g} % (standard deviation): A, C and D "
        f"are those of the typical run, and their intervals say how well {runs} runs tell it."
    ]


def scattering(scatter: Scatter, silent: bool) -> list[str]:
    """What is to be known where records scatter; `silent`: the friction force was not recorded."""
    displacement, friction = scatter.most()
    each, force = ("it", "") if silent else ("each", f" and the friction force by {friction:.2g}")
    out = [
        "What does not repeat itself from cycle to cycle counts as noise here: in the phase of the motion "
        f"where {each} scatters most, the displacement does by {displacement:.2g}{force} times the noise of "
        "its sensor."
    ]
    if scatter.left is not None:
        out.append(
            "What friction that scatters does to the displacement was taken from the measured force: "
            "faults of the mechanics are judged apart from it."
        )
    return out


def of_every_run(model: Model, first: str, named: Sequence[str]) -> list[str]:
    """What is to be known of what every run has of its own; `first` is the run that is given."""
    out = []
    for key in named:
        names = model.shelf.names(key)
        own = [name.partition(".")[2] for name in names if model.index(name)[0] in model.by_run]
        if own:
            out.append(
                f"Every run has {' and '.join(own)} of {key} of its own: given is what {first} has, and in "
                "runs that were held out they were fitted anew."
            )
    return out


def steps_taken(
    problem: Problem, model: Model, found: Attribution, base: Ground, held: Split, contact: Chosen
) -> tuple[str, ...]:
    """How the verdict was reached."""
    lanes = base.bench.lanes
    samples = int(lanes.displacement.shape[1])
    apart = ", ".join(held.files) if held.files else "every third stretch of segments"
    tried = len(found.screen.keys)
    refitted = [e for e in found.explanations if len(e.keys) == 1]
    pairs = len(found.explanations) - len(refitted)
    out = [
        f"{_runs(len(problem.chosen))} cut into {len(base.segments)} segments of at most {samples} samples, "
        "each with a start of its own.",
        f"Held out: {apart}.",
        "The nominal model was fitted with the rig free within its tolerance and the friction level free "
        f"from run to run: misfit {found.nominal.misfit:.4g} (1 is noise).",
        f"Under it friction wanders from segment to segment by {wander_of(found.nominal):.2g} % (standard "
        "deviation).",
        f"The contact is {contact.words or 'that of the assumptions, an elastic-plastic spring'}.",
        f"{tried} effects were screened and the {len(refitted)} most promising refitted.",
    ]
    if pairs:
        out.append(f"{pairs} pairs were refitted.")
    best = found.explanations[0]
    out.append(f"The lowest misfit is that of {' with '.join(best.keys)}: {best.refit.misfit:.4g}.")
    if found.floor > 1:
        out.append(
            f"From one cycle of the excitation to the next, residuals differ by {found.floor:.3g} times the "
            "noise: misfits were judged against that."
        )
    if math.isfinite(found.inflation):
        out.append(
            f"By clusters of segments, scores vary {found.inflation:.2f} times as much as white noise."
        )
    return tuple(out)


def _runs(count: int) -> str:
    return "One run was" if count == 1 else f"{count} runs were"
