"""The survey: every effect screened on the nominal model, and the promising ones refitted, each alone."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from fitting.diagnosis.judging.enough import hints, passes_for_noise, suffices
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.repeatability import floor_of
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import borrowed, released
from fitting.diagnosis.which.afresh import afresh, has_one_sign, outright
from fitting.diagnosis.which.contest import contest
from fitting.diagnosis.which.explanation import Explanation, best_of, fitted_again
from fitting.diagnosis.which.screen import Promise, Screen, Shapes, screen
from fitting.diagnosis.which.starts import FROM_NEARBY
from fitting.progress import Progress

SHORT_LIST = 10
SHORTEST_LIST = 6
PROMISING = 15.0
"""Beyond the shortest list an effect is refitted only if its score is this many times what scores vary by."""
FINALISTS = 6
LEADING = 6
REACH = 4.0
"""Lost lanes are looked after in the leading explanations, those with the lowest typical cost of a lane and
of the wandering, where that is less than so many times the lowest: one lost lane hides what an explanation is
worth."""
STRONG = 0.5
"""Where the best explanation leaves less than this share of the nominal model's misfit, what may have been
overlooked is tried:"""
OVERLOOKED = 2
"""so many effects to the end."""
LENDS = 1.5
"""The best explanation lends its lanes to those that leave less than so many times as much of a typical one:
the rest are further off than lost lanes put them."""
MUCH, HALF = 5.0, 0.5
"""Where the nominal model leaves more than so much it may be far astray, and what shows there, an effect that
explains less than a half, be none of what acts: of 640 sealed cases nine ended so, all of them off the shelf,
and one began so, whose effect was 19th of 37 by its score."""
ASTRAY = 0.2
"""A nominal model that leaves more than `MUCH`, and less than this share of it from where the best effect
stands, had lost its way: what it showed there says nothing of what acts, and all is begun anew."""
ALIKE = 1.5
"""What explains the records nearly as well, within this factor, has not been overlooked."""
NEAR = 0.95
"""An explanation that leaves hardly less has nothing to lend to another; to the nominal model it always has,
for that one can do no better than what contains it."""
NOTABLE = 1.1
"""Where the floor is higher, what does not repeat itself outweighs how the noise is known. With 1.3 two of 65
sealed cases without an effect were taken for something, their floors at 1.12 and 1.28; 13 others with floors
in between, five of them without an effect, are judged alike by either."""
SAME = 0.9
"""Aliases are the same to records in which the cosine between their traces is larger."""
COLLINEAR = 0.55
"""Traces are nearly collinear if it is larger than that. Of 692 sealed cases two effects were named in 16 of
which one leaves little alone: where one acted, that cosine was 0.58 and more in six of eight, where two did,
0.48 and less in eight of eight."""


@dataclasses.dataclass(frozen=True)
class Survey:
    """The nominal model's refit, the screening there, single effects refitted (best first), and the misfit
    that no model gets below."""

    nominal: Refit
    screen: Screen
    found: tuple[Explanation, ...]
    floor: float

    @property
    def least(self) -> float:
        """The lowest misfit there is."""
        return min(self.nominal.misfit, self.found[0].refit.misfit)

    @property
    def scatters(self) -> bool:
        """Whether what does not repeat itself is notably more than the noise."""
        return self.floor > NOTABLE

    @property
    def leads(self) -> bool:
        """Whether there is nothing to explain, or an effect explains some of it; of much a half."""
        nominal, best = self._left
        enough = nominal < MUCH or best < HALF * nominal
        return passes_for_noise(nominal) or (enough and hints(nominal, best))

    @property
    def suffices(self) -> bool:
        """Whether one effect, or none, leaves next to nothing."""
        return suffices(*self._left)

    @property
    def _left(self) -> tuple[float, float]:
        """What the nominal model and the best effect leave, in units of the floor."""
        return self.nominal.misfit / self.floor, self.found[0].refit.misfit / self.floor


def nominal_on(model: Model, bench: Bench, point: Point) -> Refit:
    """The nominal model fitted to a bench from a point on."""
    (nominal,) = refit(model, bench, [point], [model.nuisances()])
    return released(model, bench, nominal)


def survey(
    model: Model,
    bench: Bench,
    nominal: Refit,
    begins: np.ndarray,
    progress: Progress,
    known: Sequence[Explanation] = (),
) -> Survey:
    """Screens every effect on a bench beside the nominal model, as fitted there, and refits the promising
    ones, and the best of those `known` from the same lanes weighed otherwise. Where none suffices, what may
    have been overlooked is tried outright, and where no friction was recorded, all afresh from the constants
    in `begins`; but not yet where an effect leads somewhere and what scatters is still to be weighed. All is
    begun anew where the nominal model had lost its way, which it finds by the best effect.
    """
    progress.stage("effects screened", 1)
    first = screen(model, bench, nominal)
    progress.advance(f"{len(first.keys)} effects")
    promises = _short_list(model, first)
    tried = contest(model, bench, nominal, promises, FINALISTS, progress)
    found = freed(model, bench, best_of([*tried, *_again(model, bench, known)]))
    if found[0].refit.misfit < STRONG * nominal.misfit:
        others = second_look(model, bench, found, found[0].keys[0], 0, first.shapes, progress)
        found = best_of(freed(model, bench, [*found, *others])) if others else found
    best = found[0].refit
    stands = borrowed(model, bench, nominal, best, ASTRAY) if nominal.misfit > MUCH else nominal
    if stands.misfit < ASTRAY * nominal.misfit:
        return survey(model, bench, stands, begins, progress, [*known, *found])
    seen = Survey(nominal, first, tuple(found), floor_of(model, bench, [nominal, found[0].refit]))
    if seen.suffices or (seen.scatters and seen.leads and not bench.scatters):
        return seen
    others = outright(model, bench, nominal, _overlooked(model, seen), OVERLOOKED, progress)
    if not bench.wanders:
        others += afresh(model, bench, nominal, begins, first.promises, FINALISTS, progress)
    found = freed(model, bench, best_of([*found, *others]))
    floor = floor_of(model, bench, [nominal, found[0].refit])
    return Survey(nominal, first, tuple(found), floor)


def second_look(
    model: Model,
    bench: Bench,
    found: Sequence[Explanation],
    key: str,
    others: int,
    shapes: Shapes,
    progress: Progress,
) -> list[Explanation]:
    """What explains the records in place of one effect of the best explanation, sought where that one stands:
    lanes and constants of a model without a strong effect have given way to it, and what explains it as well,
    or better, may not show there. Tried are the effects that share a trace with that one, and so many others.
    """
    best = found[0]
    known = {frozenset(e.keys) for e in found if e.refit.misfit < ALIKE * best.refit.misfit}
    stays = {*best.keys} - {key}
    new = [other for other in model.shelf.effects if frozenset({*stays, other}) not in known]
    traces = {*model.shelf.traces[key]}
    mates = [other for other in new if traces & {*model.shelf.traces[other]}]
    if not mates and not others:
        return []
    bare = best.refit.stripped(model, [key])
    only = {key, *(new if others else mates)}
    at = dataclasses.replace(best.refit.showing(model, only), free=bare.free)
    seen = screen(model, bench, at, only=only, shapes=shapes, instead_of=key).promises
    promises = [promise for promise in seen if promise.key != key]
    promises = sorted(promises, key=lambda promise: promise.key not in mates)[: len(mates) + others]
    tried = contest(model, bench, bare, promises, OVERLOOKED, progress, FROM_NEARBY)

    def looked_after(e: Explanation) -> Explanation:
        return e.fitted(released(model, bench, e.refit)) if {*e.keys} & {*mates} else e

    return model.side_by_side(looked_after, tried)


def freed(
    model: Model, bench: Bench, explanations: Sequence[Explanation], leading: int = LEADING
) -> list[Explanation]:
    """The explanations, the best first; of the leading ones lost lanes are freed, and they borrow from the
    best."""

    def typical(e: Explanation) -> float:
        return e.refit.typical(bench)

    def misfit(e: Explanation) -> float:
        return e.refit.misfit

    def sifted(
        found: Sequence[Explanation], reach: float, again: Callable[[Explanation], Refit]
    ) -> list[Explanation]:
        found = sorted(found, key=typical)
        within = reach * typical(found[0])
        near = [e for e in found[:leading] if typical(e) < within]
        better = model.side_by_side(lambda e: e.fitted(again(e)), near)
        return [*better, *found[len(near) :]]

    found = sifted(explanations, REACH, lambda e: released(model, bench, e.refit))
    leader = min(found, key=misfit).refit
    found = sifted(found, LENDS, lambda e: borrowed(model, bench, e.refit, leader, NEAR))
    return sorted(found, key=misfit)


def _overlooked(model: Model, seen: Survey) -> list[Promise]:
    """What is to be tried outright: effects of one sign that were not refitted, which may show nothing at
    null, and where none explains anything, all of them, for the nominal model is astray then."""
    if not seen.leads:
        return list(seen.screen.promises)
    refitted = {e.keys[0] for e in seen.found}
    return [p for p in seen.screen.promises if p.key not in refitted and has_one_sign(model, p)]


def _again(model: Model, bench: Bench, known: Sequence[Explanation]) -> list[Explanation]:
    """The best of what is known refitted on a bench, from where they stand: of two effects together, and of
    single ones, which all leave more and beside which other pairs are sought."""
    pairs = _nearly_best([e for e in known if len(e.keys) > 1])
    singles = _nearly_best([e for e in known if len(e.keys) == 1])
    return fitted_again(model, bench, [*pairs, *singles]) if known else []


def _nearly_best(found: Sequence[Explanation]) -> list[Explanation]:
    least = min((e.refit.misfit for e in found), default=0.0)
    return [e for e in found if e.refit.misfit < ALIKE * least][:OVERLOOKED]


def aliases(model: Model, seen: Screen) -> dict[str, list[str]]:
    """The effects that leave the same trace as another in these very records."""
    traces = [set(model.shelf.traces[key]) for key in seen.keys]
    return {
        key: [
            other
            for there, other in enumerate(seen.keys)
            if here != there and traces[here] & traces[there] and seen.cosine[here, there] > SAME
        ]
        for here, key in enumerate(seen.keys)
    }


def collinear(seen: Screen) -> dict[str, list[str]]:
    """The effects whose traces are nearly collinear with another's: each does in part what the other does."""
    return {
        key: [
            other for other, cosine in zip(seen.keys, row, strict=True) if key != other and cosine > COLLINEAR
        ]
        for key, row in zip(seen.keys, seen.cosine, strict=True)
    }


def _short_list(model: Model, seen: Screen) -> list[Promise]:
    """The promises that are worth a refit, each with its aliases."""
    chosen = [
        promise.key
        for place, promise in enumerate(seen.ranked[:SHORT_LIST])
        if place < SHORTEST_LIST or promise.standing > PROMISING
    ]
    same = aliases(model, seen)
    wanted = {*chosen, *(other for key in chosen for other in same[key])}
    return [promise for promise in seen.promises if promise.key in wanted]
