"""Which effect: what the survey found, pairs where one effect leaves more than noise, and all of them
weighed."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.accounts import Account, within_scatter
from fitting.diagnosis.findings import Yardstick
from fitting.diagnosis.judging.credit import AS_LITTLE, NEARLY_BEST
from fitting.diagnosis.judging.enough import hints, is_nothing_but_noise, leaves_nothing, passes_for_noise
from fitting.diagnosis.judging.judge import judge
from fitting.diagnosis.judging.judgement import Judgement
from fitting.diagnosis.judging.one_class import classes
from fitting.diagnosis.judging.reconsidered import astray, refuted
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.layout import strengths_of
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.steadiness import Levels, steadier
from fitting.diagnosis.noise.repeatability import floor_of, wanders
from fitting.diagnosis.refits.influence import told_by_many
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import borrowed, released
from fitting.diagnosis.which.chain import on_the_other_side, other_way_round
from fitting.diagnosis.which.contacts import NOTABLE, carried
from fitting.diagnosis.which.contained import brought_level, lent, none_above
from fitting.diagnosis.which.explanation import Explanation, best_of
from fitting.diagnosis.which.in_step import in_step
from fitting.diagnosis.which.pairs import each_alone, in_place_of_either, pairs_beside, with_still_friction
from fitting.diagnosis.which.screen import Screen, screen
from fitting.diagnosis.which.survey import Survey, aliases, collinear, freed
from fitting.progress import Progress

PROMISING = 20.0
"""Where what one effect leaves passes for noise, a second is sought only if its score is so many times what
scores vary by: where only few segments show it, no score can be."""
WORTH = 0.03
"""Where it leaves nothing that the noise as stated would not, one is sought nevertheless if its score is so
large a share of what is left, too: noise may be less than is stated."""
MORE_THAN_ONE = 0.8
"""Contacts are tried beside two effects that leave less than this share of what one leaves."""
CARRIED, ALONE = 8, 4
"""So many explanations are fitted once more, and so many single effects at least: under a contact that the
best of them asks for, or weighed anew."""
BEST = 2
"""Of so many explanations the links of the measuring chain are tried the other way round."""
LOST = 0.05
"""No more than this share of the lanes is lost where nothing acts."""
AT_NULL = 1e-3
"""An effect none of whose strengths is a larger share of its typical size does nothing: if friction is
steadier with it, the search has found other starts, and no effect is needed for these. Of 1000 sealed cases
two ended in such a name, both wrongly."""
PIECES_A_LANE, PIECES_FREED = 1.0, 3.0
"""So many independent pieces of evidence has a lane in which scatter outweighs the noise, and so many where
the displacement is freed of it."""


@dataclasses.dataclass(frozen=True)
class Attribution:
    """The nominal model's refit, the explanations (best first), the screening that led to them, the
    judgement, and what misfits were judged against."""

    nominal: Refit
    explanations: tuple[Explanation, ...]
    screen: Screen
    judgement: Judgement
    yardstick: Yardstick

    @property
    def floor(self) -> float:
        """The misfit that no model gets below, for it does not repeat itself from cycle to cycle."""
        return self.yardstick.floor

    @property
    def inflation(self) -> float:
        """By how much scores vary more than white noise."""
        return self.yardstick.inflation

    @property
    def lost(self) -> float:
        """The share of the lanes that the nominal model fits so much worse than the rest that they count for
        less than half."""
        return float(np.mean(self.nominal.weights < 0.5))

    def share_that_counts(self, keys: tuple[str, ...]) -> float:
        """The share that counts of what friction is steadier under an explanation: what a second effect adds
        to that by mending the shape of the first does not, here nor on what took no part."""
        counted, measured = self.judgement.steadier.get(keys, 0.0), self._account(keys).steadier
        return counted / measured if measured > counted else 1.0

    def adds_nothing(self, two: tuple[str, ...], one: tuple[str, ...]) -> bool:
        """Whether two effects do no more here than the `one` of them that is meant: they leave as much, and
        are credited with no steadier friction."""
        steadier = self.judgement.steadier
        as_much = self._account(one).misfit <= AS_LITTLE * self._account(two).misfit
        return {*one} < {*two} and as_much and steadier.get(two, 0.0) <= steadier.get(one, 0.0)

    def _account(self, keys: tuple[str, ...]) -> Account:
        return next(account for account in self.yardstick.accounts if account.keys == keys)

    def grows_by_chance(self, keys: tuple[str, ...]) -> float:
        """How many times as large a gap is with an explanation as without, in the mean, on what took no part
        where its effects do not show: its parameters are known no better than what was fitted tells them, by
        which chi-square is 1 + parameters inflation/samples times as large."""
        return math.sqrt(1 + self._account(keys).parameters * self.inflation / self.yardstick.samples)

    @property
    def shows_no_gap(self) -> bool:
        """Whether the nominal model leaves what passes for noise."""
        return passes_for_noise(self.nominal.misfit / self.floor)

    def refuted(self) -> Attribution:
        """The same where what is named is not the cause, as `reconsidered.refuted` has it."""
        return dataclasses.replace(self, judgement=refuted(self.judgement))

    def astray(self) -> Attribution:
        """The same where whatever acts is not nothing, as `reconsidered.astray` has it."""
        return dataclasses.replace(self, judgement=astray(self.judgement))

    @property
    def leading(self) -> tuple[Explanation, ...]:
        """The best explanations, the best single effects, and each effect of the very best alone."""
        best, *_ = self.explanations
        singles = [e.keys[0] for e in self.explanations if len(e.keys) == 1]
        alone = {*singles[:ALONE], *best.keys}
        return tuple(
            e
            for place, e in enumerate(self.explanations)
            if place < CARRIED or (len(e.keys) == 1 and e.keys[0] in alone)
        )

    @property
    def asks_for_a_contact(self) -> bool:
        """Whether two effects explain more than one, beside which contacts have been tried, and still leave
        notably more than what no model gets below."""
        best, *others = self.explanations
        left = best.refit.misfit - self.floor
        alone = min((e.refit.misfit - self.floor for e in others if len(e.keys) == 1), default=math.inf)
        return len(best.keys) > 1 and NOTABLE * self.floor < left < MORE_THAN_ONE * alone


def attribute(
    model: Model, bench: Bench, seen: Survey, progress: Progress, known: Sequence[Explanation] = ()
) -> Attribution:
    """Looks for pairs where one effect leaves more than noise, and weighs all explanations, the pairs among
    them that are `known`."""
    nominal, first, found, floor = seen.nominal, seen.screen, list(seen.found), seen.floor
    if wanders(nominal) and (wanders(found[0].refit) or not seen.suffices):
        still = with_still_friction(model, bench, nominal, found[0], first.shapes, progress)
        found = freed(model, bench, best_of([*found, *still]))
    found = best_of([*found, *known])
    found = best_of([*found, *other_way_round(model, bench, found[:BEST], floor)])
    singles = [e for e in found if len(e.keys) == 1]
    changing = in_step(model, bench, nominal, singles, first.shapes, progress)
    found = best_of([*found, *changing])
    nominal, found = _lent_on(model, bench, nominal, found)
    best, singles = found[0], [e for e in found if len(e.keys) == 1]
    floor = min(floor, floor_of(model, bench, [nominal, best.refit]))
    left = nominal.misfit / floor, best.refit.misfit / floor
    alone = leaves_nothing(*left) if best is singles[0] else is_nothing_but_noise(left[1])
    around = screen(model, bench, singles[0].refit, own_group=alone, shapes=[] if alone else None)
    if alone and worth_a_second(bench, singles[0].refit, around):
        alone, around = False, screen(model, bench, singles[0].refit)
    promising = any(promise.standing > PROMISING for promise in around.promises)
    pairs = [e for e in found if len(e.keys) > 1]
    if not alone and hints(*left) and (promising or not passes_for_noise(left[1])):
        pairs = best_of([*pairs, *pairs_beside(model, bench, singles, around, floor, progress)])
    elif len(best.keys) > 1:
        pairs = in_place_of_either(model, bench, pairs, 0, first.shapes, progress)
    return _all_together(model, bench, nominal, singles, pairs, first, around, floor, progress)


def with_pairs_anew(model: Model, bench: Bench, found: Attribution, progress: Progress) -> Attribution:
    """The same, with pairs sought on a bench that residuals are weighed anew on since, where nothing known
    leaves what passes for noise there: what they were weighed by before hid the second effect."""
    singles, pairs = ([e for e in found.explanations if (len(e.keys) > 1) is two] for two in (False, True))
    best, floor = singles[0].refit, found.floor
    leaves = found.explanations[0].refit.misfit / floor
    if passes_for_noise(leaves) or not hints(found.nominal.misfit / floor, best.misfit / floor):
        return found
    around = screen(model, bench, best)
    pairs = best_of([*pairs, *pairs_beside(model, bench, singles, around, floor, progress)])
    return _all_together(model, bench, found.nominal, singles, pairs, found.screen, around, floor, progress)


def _all_together(
    model: Model,
    bench: Bench,
    nominal: Refit,
    singles: Sequence[Explanation],
    pairs: Sequence[Explanation],
    first: Screen,
    around: Screen,
    floor: float,
    progress: Progress,
) -> Attribution:
    """All explanations weighed, each effect of the best pairs by itself among them, and lanes that are lost
    in one and not in another found in either. Where no two leave what passes for noise, links of the
    measuring chain are tried in the order in which they were not."""
    found = list(singles)
    if pairs:
        pairs = best_of([*pairs, *other_way_round(model, bench, pairs[:BEST], floor)])
        if not passes_for_noise(pairs[0].refit.misfit / floor):
            turned = on_the_other_side(model, bench, singles[0], around, progress)
            pairs = best_of([*pairs, *turned])
        found = best_of([*singles, *pairs, *each_alone(model, bench, singles, pairs, first)])
    nominal, found = _level(model, bench, nominal, found)
    return _weighed(model, bench, nominal, found, first, _inflation(bench, around, floor), floor)


def _level(
    model: Model, bench: Bench, nominal: Refit, found: Sequence[Explanation]
) -> tuple[Refit, list[Explanation]]:
    """The nominal model and the explanations, best first, of which those next to the best have borrowed from
    it. Where one of these ends below it, it has found what is lost in all others, and lends that in turn to
    the nominal model, and so to all."""
    level = brought_level(model, bench, found)
    ends_below = level[0].refit.misfit < min(e.refit.misfit for e in found)
    return _lent_on(model, bench, nominal, level) if ends_below else (nominal, level)


def _lent_on(
    model: Model, bench: Bench, nominal: Refit, found: Sequence[Explanation]
) -> tuple[Refit, list[Explanation]]:
    """The nominal model with what the best explanation lends to it, and all of them, best first, with what it
    lends to those that end above it."""
    nominal = borrowed(model, bench, nominal, found[0].refit)
    return nominal, none_above(model, bench, nominal, found)


def on_another_contact(model: Model, bench: Bench, found: Attribution, other: Model) -> Attribution:
    """The best explanations and the nominal model fitted once more under another contact, weighed there."""
    fits = found.nominal, *(e.refit for e in found.leading)
    nominal, best = _again(other, bench, found, [carried(fit, model, other) for fit in fits])
    floor = min(found.floor, floor_of(other, bench, [nominal]))
    return _weighed(other, bench, nominal, best, found.screen, found.inflation, floor)


def on_another_bench(model: Model, bench: Bench, found: Attribution) -> Attribution:
    """The best explanations and the nominal model fitted once more to the same lanes weighed otherwise, and
    judged by that."""
    fits = found.nominal, *(e.refit for e in found.leading)
    nominal, best = _again(model, bench, found, fits)
    leader = min(best, key=lambda e: e.refit.misfit).refit
    around = screen(model, bench, leader, own_group=True, shapes=[])
    floor = floor_of(model, bench, [nominal, leader])
    return _weighed(model, bench, nominal, best, found.screen, _inflation(bench, around, floor), floor)


def _again(
    model: Model, bench: Bench, found: Attribution, begun: Sequence[Refit]
) -> tuple[Refit, list[Explanation]]:
    """The nominal model and the leading explanations, fitted once more from where these have begun; and those
    that end above the nominal model, which they contain, with that one's lanes and constants lent to them."""
    fits = refit(model, bench, [fit.point for fit in begun], [fit.free for fit in begun])
    nominal, *others = model.side_by_side(lambda fit: released(model, bench, fit), fits)
    best = [e.fitted(fit) for e, fit in zip(found.leading, others, strict=True)]
    return nominal, lent(model, bench, nominal, best)


def _weighed(
    model: Model,
    bench: Bench,
    nominal: Refit,
    found: Sequence[Explanation],
    first: Screen,
    inflation: float,
    floor: float,
) -> Attribution:
    found = sorted(found, key=lambda explanation: explanation.refit.misfit)
    floor = min(floor, floor_of(model, bench, [found[0].refit]))
    near = [e.refit.levels for e in found if e.refit.misfit < NEARLY_BEST * found[0].refit.misfit]
    restless = bench.wanders and wanders(nominal)
    known = nominal.levels.where_none_lost(near) if restless else None
    left = (misfit / floor for misfit in _told(bench, nominal, found))
    accounts = tuple(account(model, bench, known, e, misfit) for e, misfit in zip(found, left, strict=True))
    accounts = within_scatter(accounts) if bench.scatters else accounts
    samples, alike, mending = float(bench.dof().sum()), aliases(model, first), collinear(first)
    without = told_by_many(bench, nominal)
    judgement = judge(
        without / floor,
        accounts,
        samples,
        inflation,
        list(model.shelf.effects),
        alike,
        classes(
            traces_left(model, first),
            {frozenset(e.keys): e.refit.misfit for e in found},
        ),
        hidden=model.shelf.of_friction() if bench.scatters else (),
        collinear=mending,
    )
    against = Yardstick(without, floor, samples, inflation, bench.scatters, accounts, alike, mending)
    made = Attribution(nominal, tuple(found), first, judgement, against)
    return made.astray() if made.lost > LOST else made


def traces_left(model: Model, seen: Screen) -> dict[str, tuple[str, ...]]:
    """The traces of every effect of the shelf in these records; none where it cannot be seen in them, as a
    gain of a base that stands still."""
    visible = {promise.key for promise in seen.usual if promise.can_be_seen}
    return {key: traces if key in visible else () for key, traces in model.shelf.traces.items()}


def _told(bench: Bench, nominal: Refit, found: Sequence[Explanation]) -> list[float]:
    """The misfits of the explanations, best first, as more than one lane tells them: compared with the
    nominal model, and those of two effects with the better of them alone, too."""
    alone = [e for e in found if len(e.keys) == 1]

    def compared_with(e: Explanation) -> list[Refit]:
        parts = [one.refit for one in alone if len(e.keys) > 1 and one.keys[0] in e.keys]
        return [nominal, *parts[:1]]

    return [told_by_many(bench, e.refit, compared_with(e)) for e in found]


def worth_a_second(bench: Bench, alone: Refit, around: Screen) -> bool:
    """Whether a second effect promises to take a good part of what one leaves."""
    share = WORTH * alone.misfit * float(bench.dof().sum())
    return any(promise.standing > PROMISING and promise.score > share for promise in around.promises)


def _inflation(bench: Bench, seen: Screen, floor: float) -> float:
    """By how much scores vary more than white residuals say; friction that scatters does so in step for a
    good part of a lane, and may for more than one. Scatter that residuals are not weighed by is that part of
    them which is above the noise."""
    pieces = (PIECES_A_LANE if bench.whitener is None else PIECES_FREED) * len(bench.lanes)
    in_step = float(bench.dof().sum()) / pieces
    share = 1.0 if bench.scatters else 1.0 - 1.0 / max(floor, 1.0)
    return max(seen.inflation, 1.0 + share * (in_step - 1.0))


def account(
    model: Model, bench: Bench, before: Levels | None, explanation: Explanation, misfit: float
) -> Account:
    """The account of an explanation that leaves this misfit, in units of the floor. A strength that every
    run has of its own counts once, and for the other runs as far as these differ from one another. `before`:
    the levels of friction under the nominal model, None where it keeps still."""
    keys, fit, runs = explanation.keys, explanation.refit, np.unique(bench.run)
    parameters, of_one_run = 0, 0.0
    for number in np.concatenate([model.of(key) for key in keys]):
        parameters += 1
        if number in model.by_run:
            own = fit.point.by_run[runs][:, model.by_run == number]
            of_one_run += (len(runs) - 1) * float(np.var(own) / max(np.mean(own**2), 1e-300))
    steady = 0.0
    if before is not None and _acts(model, bench, explanation):
        steady = max(steadier(before, fit.levels, bench.run), 0.0)
    of_friction = model.shelf.of_friction(keys)
    changing = tuple(key for key in keys if model.shelf.effects[key].changes)
    given = model.index(*(name for key in keys for name in model.shelf.shapes[key]))
    samples = float(bench.dof().sum())
    shapes = tuple(fit.told[number] / samples for number in given.tolist() if number in fit.told)
    return Account(keys, misfit, parameters, of_one_run, len(runs), steady, of_friction, shapes, changing)


def _acts(model: Model, bench: Bench, explanation: Explanation) -> bool:
    """Whether any of the effects has a strength to speak of."""
    point = explanation.refit.point
    return any((np.abs(strengths_of(model, bench, point, key)) > AT_NULL).any() for key in explanation.keys)
