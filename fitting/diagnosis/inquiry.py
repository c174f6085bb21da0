"""One inquiry: what explains the runs that are fitted, and what those that took no part say of it."""

from __future__ import annotations

import dataclasses
import math

from fitting.diagnosis.findings import Closure
from fitting.diagnosis.how_far.shrink import (
    CARRIES_OVER,
    CLEARLY,
    ONLY_HERE,
    Split,
    closes,
    closure,
    gain,
    left_open,
    refutes,
    shows_more,
    stays_open,
    steadies,
    worsens,
)
from fitting.diagnosis.judging.enough import passes_for_noise
from fitting.diagnosis.judging.judgement import Judgement
from fitting.diagnosis.judging.reconsidered import refuted, succeeded, weighed_again
from fitting.diagnosis.judging.verdict import NONE, UNLISTED
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.jobs import predicted
from fitting.diagnosis.noise.ground import resolved
from fitting.diagnosis.noise.scatter import Scatter
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.turns import less_scattered, surveyed, weighed_anew
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly
from fitting.diagnosis.unlisted.bad_samples import bad_samples
from fitting.diagnosis.unlisted.bursts import bursts
from fitting.diagnosis.unlisted.held_samples import held_samples
from fitting.diagnosis.unlisted.jumps import jumps
from fitting.diagnosis.unlisted.own_beat import own_beat
from fitting.diagnosis.unlisted.unrest import Unrest, unrest
from fitting.diagnosis.which.attribute import Attribution, attribute
from fitting.diagnosis.which.contacts import Chosen
from fitting.diagnosis.which.explanation import Explanation, told_apart
from fitting.diagnosis.which.other_contact import beside_a_pair, in_place_of_one_of_two
from fitting.diagnosis.words import few_there, only_there, refutation
from fitting.progress import Progress

ONLY_THERE = 1.1
"""Runs that took no part, and leave so many times their floor, show a gap that the others do not. Where
nothing acted and nothing scattered none of 57 sealed cases left more than 1.06; one left 1.19 in which
something did."""
SEVERAL = 2.0
"""and do so in more than one or two of their segments: the gap stands as many standard deviations above the
floor, counted by segments. A start from which a segment may as well slip as stick opens one of 1.12 by itself
(two of 28 segments of a sealed case without an effect)."""
PLAUSIBLE = 0.03
"""What succeeds an explanation that runs speak against which took no part was so many times as likely."""


@dataclasses.dataclass(frozen=True)
class Inquiry:
    """What explains the lanes that are fitted: the contact, the bench of these lanes, the attribution, and
    what the verdict rests on; how far the gap shrinks on the lanes that are held out; what is seen that no
    effect does, the plainest first; and what speaks against the verdict."""

    chosen: Chosen
    bench: Bench
    held: Split
    found: Attribution
    named: Explanation | None
    shrunk: Closure
    anomalies: tuple[AbstractAnomaly, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def gapes_only_there(self) -> bool:
        """Whether nothing is found where the lanes were fitted, and those held out show a gap all the same.
        Where friction scatters, the floor of the few that are held out says too little for that."""
        return self._is_above_the_floor_there and self.shrunk.significance > SEVERAL

    @property
    def _is_above_the_floor_there(self) -> bool:
        nothing = self.found.judgement.verdict == "none" and not self.bench.scatters
        return nothing and self.shrunk.before > ONLY_THERE * self.shrunk.floor

    @property
    def lacks_only_there(self) -> bool:
        """Whether one effect leaves next to nothing where the lanes were fitted, and those held out show that
        something else acts. Where friction scatters, the floor of these says too little for that."""
        if self.named is None or len(self.named.keys) > 1 or self.bench.scatters:
            return False
        return passes_for_noise(self.named.refit.misfit / self.found.floor) and shows_more(self.shrunk)

    @property
    def is_doubted_there(self) -> bool:
        """Whether only what was held out shows a gap, or that something else acts."""
        return self.gapes_only_there or self.lacks_only_there

    def says_more_than(self, other: Inquiry) -> bool:
        """Whether it names something where the other names nothing, or two effects, of which the other names
        one, and lacks nothing then."""
        if self.named is None or other.named is None:
            return self.named is not None
        same = not {*other.found.judgement.named}.isdisjoint(self.named.keys)
        return same and len(self.named.keys) > 1 and not shows_more(self.shrunk)

    def disproved(self, anomaly: AbstractAnomaly | None) -> Inquiry:
        """The inquiry once it is seen that what is named, or whatever is taken for noise, does what no effect
        on the shelf does: what is named is not the cause, and where nothing is, it is not nothing."""
        if anomaly is None:
            return self
        seen = (anomaly, *self.anomalies)
        if self.named is None:
            return dataclasses.replace(self, found=self.found.astray(), anomalies=seen)
        shrunk = left_open(self.shrunk)
        return dataclasses.replace(
            self, found=self.found.refuted(), named=None, shrunk=shrunk, anomalies=seen
        )

    def qualified(self) -> Inquiry:
        """The inquiry that says so where a few segments that were held out are all that shows a gap."""
        few = self._is_above_the_floor_there and not self.gapes_only_there
        return dataclasses.replace(self, doubts=(*self.doubts, few_there(self.shrunk))) if few else self

    def unexplained(self) -> Inquiry:
        """The inquiry once what gapes only there is no "none": something acts that the fitted lanes do not
        show."""
        doubts = (*self.doubts, only_there(self.shrunk))
        return dataclasses.replace(self, found=self.found.astray(), doubts=doubts)


def inquire(paper: Chosen, held: Split, seed: int, progress: Progress) -> Inquiry:
    """Every effect of the shelf is tried on the lanes that are fitted, on the paper's contact and on others,
    and the shrinking of the gap is measured on those that are held out."""
    begin = paper.ground.point.take(held.fitted)
    plain = resolved(paper.model, paper.ground.bench.take(held.fitted), begin)
    chosen, bench, seen = surveyed(paper, plain, begin, held, progress)
    found = attribute(chosen.model, bench, seen, progress)
    chosen, bench, found = weighed_anew(paper, chosen, bench, plain, held, found)
    chosen, bench, found = less_scattered(paper, chosen, bench, plain, held, found, progress)
    if chosen.words is None and found.asks_for_a_contact:
        chosen, found = beside_a_pair(chosen, bench, found, held, progress)
    if chosen.words is None:
        chosen, found = in_place_of_one_of_two(chosen, bench, found, held, progress)
    found, anomalies = _off_the_shelf(paper, chosen, found)
    progress.stage("how far the gap shrinks", 1)
    first = _named(found)
    rival = None if first is None else _rival(found, first)
    shrunk = _shrunk(chosen, held, found, first, seed, rival)
    named, doubts = first, ()
    if first is not None:
        judged = confirmed(found, first, shrunk, rival)
        instead = _succeeded(chosen, held, found, first, seed) if judged.verdict == UNLISTED else None
        found = dataclasses.replace(found, judgement=instead or judged)
        named = _named(found)
        if named is None:
            doubts = (refutation(first.keys, shrunk),)
            shrunk = left_open(shrunk)
            found, anomalies = _off_the_shelf(paper, chosen, found)
        elif named is not first:
            doubts = () if instead is None else (refutation(first.keys, shrunk),)
            shrunk = _shrunk(chosen, held, found, named, seed)
    progress.advance()
    inquiry = Inquiry(chosen, bench, held, found, named, shrunk, anomalies, doubts)
    return _unless_restless(paper, inquiry, plain)


def _off_the_shelf(
    paper: Chosen, chosen: Chosen, found: Attribution
) -> tuple[Attribution, tuple[AbstractAnomaly, ...]]:
    """What is seen that no effect does, and the attribution with it. It is looked for where nothing is named,
    for what is named may look so to the nominal model; scatter that is no wandering only where nothing seems
    to act."""
    if found.judgement.named:
        return found, ()
    nothing = found.judgement.verdict == "none"
    problem, model, bench, point = paper.problem, paper.model, paper.ground.bench, paper.ground.point
    seen = predicted(model, bench, point)
    strange: list[AbstractAnomaly | None] = [
        bad_samples(problem),
        bursts(bench, seen, problem.period),
        held_samples(bench, seen),
        jumps(bench, seen),
        own_beat(problem, model, bench, point, seen),
    ]
    if nothing:
        strange.append(unrest(chosen.problem, chosen.model, found.nominal, chosen.ground.scatter))
    anomalies = tuple(anomaly for anomaly in strange if anomaly is not None)
    return found.astray() if nothing and anomalies else found, anomalies


def _unless_restless(paper: Chosen, inquiry: Inquiry, plain: Bench) -> Inquiry:
    """The inquiry once friction is known to scatter under what is named, and with that whatever else is seen
    that no effect does."""
    restless = _unrest_beside(inquiry, plain)
    if restless is None:
        return inquiry
    disproved = inquiry.disproved(restless)
    _, besides = _off_the_shelf(paper, inquiry.chosen, disproved.found)
    return dataclasses.replace(disproved, anomalies=(*besides, *disproved.anomalies))


def _unrest_beside(inquiry: Inquiry, plain: Bench) -> Unrest | None:
    """Scatter that is no wandering under what is named, where that closes no gap: friction that is steadier
    with it may be so by chance, and whatever scatters so is not explained. `plain`: the bench in units of the
    noise."""
    named, chosen = inquiry.named, inquiry.chosen
    if named is None or not inquiry.found.shows_no_gap or closes(inquiry.shrunk):
        return None
    model, problem = chosen.model, chosen.problem
    scatter = Scatter.of(model, plain, named.refit.point, problem.period)
    return unrest(problem, model, named.refit, scatter)


def _named(found: Attribution) -> Explanation | None:
    """The explanation that the verdict rests on, the likeliest of what it names; None for nothing named."""
    taken = set(found.judgement.taken)
    return next(e for e in found.explanations if set(e.keys) == taken) if taken else None


def _rival(found: Attribution, named: Explanation) -> Explanation | None:
    """The likeliest of the other explanations that share an effect with what is named, and are credited with
    steadier friction: none is told from it by anything else as little as these are."""
    judged = found.judgement
    others = [e for e in found.explanations if {*e.keys} & {*named.keys} and e.keys != named.keys]
    others = [e for e in others if judged.steadier.get(e.keys, 0.0) > 0]
    return max(others, key=lambda e: judged.explanations["+".join(e.keys)], default=None)


def confirmed(
    found: Attribution, named: Explanation, shrunk: Closure, rival: Explanation | None = None
) -> Judgement:
    """The judgement once runs that took no part have spoken for or against what is named, and a rival that
    shares an effect with it.

    An effect that is named since it makes friction steadier, where there is no gap, explains what runs show
    that took no part, too, if it explains anything; but what closes a gap there need not make friction
    steadier as well. Where there is none to be closed, parameters that are not known well may open one. A
    second effect that adds nothing to the one that is named, where they were fitted, may mend its shape on
    other runs: that does not call for it.
    """
    least = 0.0 if closes(shrunk) else -math.inf

    def counted(keys: tuple[str, ...], steadier: float) -> float:
        return found.share_that_counts(keys) * max(steadier, least)

    worth, others = counted(named.keys, shrunk.steadier), dict[tuple[str, ...], float]()
    if rival is not None and shrunk.rival is not None:
        its = counted(rival.keys, shrunk.rival)
        others[rival.keys] = min(its, worth) if found.adds_nothing(rival.keys, named.keys) else its
    judgement = weighed_again(found.judgement, named.keys, worth, others)
    if not judgement.named:
        return judgement
    if steadies(shrunk, judgement.steadier[named.keys]):
        no_cause = found.shows_no_gap and stays_open(shrunk, ONLY_HERE)
        return refuted(judgement, NONE) if no_cause else judgement
    if refutes(shrunk, gain(found.nominal, named.refit)):
        return refuted(judgement, UNLISTED)
    if found.shows_no_gap:
        return refuted(judgement, NONE) if worsens(shrunk) else judgement
    clearly = max(CLEARLY, found.grows_by_chance(named.keys))
    return refuted(judgement, UNLISTED) if worsens(shrunk, clearly) else judgement


def _succeeded(
    chosen: Chosen, held: Split, found: Attribution, first: Explanation, seed: int
) -> Judgement | None:
    """The judgement where runs that took no part speak against what was named, and for the likeliest of what
    leaves less of those that were fitted, and has no more effects: what acts in a few runs alone, as an end
    stop, may be taken for something simpler. None where they speak for nothing of that."""
    judged = found.judgement

    def likely(e: Explanation) -> float:
        return judged.explanations["+".join(e.keys)]

    better = [
        e
        for e in found.explanations
        if e.refit.misfit < first.refit.misfit
        and len(e.keys) <= len(first.keys)
        and likely(e) > PLAUSIBLE * likely(first)
    ]
    if not better:
        return None
    heir = max(better, key=likely)
    found = dataclasses.replace(found, judgement=succeeded(judged, first.keys, heir.keys))
    if _named(found) is not heir:
        return None
    shrunk = _shrunk(chosen, held, found, heir, seed)
    carries_over = shrunk.gain > CARRIES_OVER * gain(found.nominal, heir.refit)
    return confirmed(found, heir, shrunk) if carries_over else None


def _shrunk(
    chosen: Chosen,
    held: Split,
    found: Attribution,
    named: Explanation | None,
    seed: int,
    rival: Explanation | None = None,
) -> Closure:
    """How far the gap shrinks on what was held out."""
    base, fits = chosen.ground, _fits(found, named, rival)
    shrunk = closure(chosen.problem, chosen.model, base.bench, held, fits, base.point.own, seed)
    wrong = next((e.keys for e in found.explanations if e.refit is fits.get("wrong")), ())
    return dataclasses.replace(shrunk, wrong_keys=wrong)


def _fits(
    found: Attribution, named: Explanation | None, rival: Explanation | None = None
) -> dict[str, Refit]:
    """The fits whose gaps are compared on what was held out: those of the nominal model, of what is named and
    of its rival, and, of what shares no effect with that and has no more, the best that the records tell from
    it, and the worst."""
    if named is None:
        return {"nominal": found.nominal, "named": found.nominal}
    fits = {"nominal": found.nominal, "named": named.refit}
    if rival is not None:
        fits["rival"] = rival.refit
    mentioned, most = set(found.judgement.named), len(named.keys)
    others = [e for e in found.explanations if not mentioned & set(e.keys) and len(e.keys) <= most]
    wrong = next((e for e in others if told_apart(named, e)), None)
    if wrong is not None:
        fits["wrong"] = wrong.refit
    if others:
        fits["placebo"] = others[-1].refit
    return fits
