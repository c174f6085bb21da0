"""Which effect: what the survey found, pairs where one effect leaves more than noise, and all of them
weighed."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.bench import Bench
from fitting.diagnosis.contacts import NOTABLE, carried, free_under
from fitting.diagnosis.contest import Explanation, best_of, contest
from fitting.diagnosis.findings import Yardstick
from fitting.diagnosis.judge import Account, Judgement, hints, judge, leaves_nothing, passes_for_noise
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import Refit, refit
from fitting.diagnosis.release import borrowed, released
from fitting.diagnosis.repeatability import floor_of, wanders
from fitting.diagnosis.screen import Screen, Shapes, screen
from fitting.diagnosis.survey import FINALISTS, STRONG, Survey, aliases, freed, second_look
from fitting.diagnosis.wander import LEAST, OWN, START
from fitting.progress import Progress

SECONDS, FINAL_PAIRS = 5, 3
"""So many effects are tried beside each of the `LEADERS`, and so many of these to the end."""
LEADERS = 2
PROMISING = 20.0
"""Where what one effect leaves passes for noise, a second is sought only if its score is so many times what
scores vary by: where only few segments show it, no score can be."""
INSTEAD = 3
"""So many effects are tried in the place of each of the two of the best pair."""
CARRIED = 8
"""So many explanations are fitted once more under a contact that the best of them asks for."""
PIECES_A_LANE = 3.0
"""So many independent pieces of evidence has a lane in which scatter outweighs the noise."""
RIVAL = 2.0
"""Pairs are sought with the best effect, and with the second best where it leaves less than so many times as
much."""


@dataclasses.dataclass(frozen=True)
class Attribution:
    """The nominal model's refit, the explanations (best first), the screening that led to them, the
    judgement; by how much scores vary more than white noise, and the misfit that no model can get below, for
    it does not repeat itself from cycle to cycle."""

    nominal: Refit
    explanations: tuple[Explanation, ...]
    screen: Screen
    judgement: Judgement
    inflation: float
    floor: float
    samples: float

    @property
    def yardstick(self) -> Yardstick:
        """What misfits are judged against."""
        return Yardstick(self.nominal.misfit, self.floor, self.samples, self.inflation)

    @property
    def shows_no_gap(self) -> bool:
        """Whether the nominal model leaves what passes for noise."""
        return passes_for_noise(self.nominal.misfit / self.floor)

    @property
    def asks_for_a_contact(self) -> bool:
        """Whether two effects explain far more than one, beside which contacts have been tried, and still
        leave notably more than what no model gets below."""
        best, *others = self.explanations
        left = best.refit.misfit - self.floor
        alone = min((e.refit.misfit - self.floor for e in others if len(e.keys) == 1), default=math.inf)
        return len(best.keys) > 1 and NOTABLE * self.floor < left < STRONG * alone


def attribute(model: Model, bench: Bench, seen: Survey, progress: Progress) -> Attribution:
    """Looks for pairs where one effect leaves more than noise, and weighs all explanations."""
    nominal, first, found, floor = seen.nominal, seen.screen, list(seen.found), seen.floor
    if wanders(nominal) and (wanders(found[0].refit) or not seen.suffices):
        still = _with_still_friction(model, bench, nominal, found[0], first.shapes, progress)
        found = freed(model, bench, best_of([*found, *still]))
    best, singles = found[0], [e for e in found if len(e.keys) == 1]
    nominal = borrowed(model, bench, nominal, best.refit)
    floor = min(floor, floor_of(model, bench, [nominal, best.refit]))
    left = nominal.misfit / floor, best.refit.misfit / floor
    alone = leaves_nothing(*left)
    around = screen(model, bench, singles[0].refit, own_group=alone, shapes=[] if alone else first.shapes)
    promising = any(promise.standing > PROMISING for promise in around.promises)
    pairs = [e for e in found if len(e.keys) > 1]
    if not alone and hints(*left) and (promising or not passes_for_noise(left[1])):
        pairs = best_of([*pairs, *_pairs(model, bench, singles, around, first.shapes, progress)])
        pairs.sort(key=lambda pair: pair.refit.misfit)
    if pairs:
        found = best_of([*singles, *pairs, *each_alone(model, bench, singles, pairs, first)])
    return _weighed(model, bench, nominal, found, first, _inflation(bench, around), floor)


def on_another_contact(model: Model, bench: Bench, found: Attribution, other: Model) -> Attribution:
    """The best explanations and the nominal model fitted once more under another contact, weighed there."""

    def again(fit: Refit) -> Refit:
        point = carried(fit.point, model, other)
        (moved,) = refit(other, bench, [point], [free_under(fit, model, other)])
        return released(other, bench, moved)

    best = found.explanations[:CARRIED]
    nominal, *fits = other.side_by_side(again, [found.nominal, *(e.refit for e in best)])
    explanations = [dataclasses.replace(e, refit=fit) for e, fit in zip(best, fits, strict=True)]
    floor = min(found.floor, floor_of(other, bench, [nominal]))
    return _weighed(other, bench, nominal, explanations, found.screen, found.inflation, floor)


def each_alone(
    model: Model, bench: Bench, found: Sequence[Explanation], pairs: Sequence[Explanation], seen: Screen
) -> list[Explanation]:
    """The effects of the best pairs, each by itself from where it stands beside the other, if the pair leaves
    far less than the effect was found to leave alone: whatever came second may only have helped over a hill
    between the nominal model and what one effect explains."""
    alone = {e.keys[0]: e.refit.misfit for e in found if len(e.keys) == 1}
    promises = {promise.key: promise for promise in seen.promises}
    beside = {key: pair for pair in reversed(pairs[:LEADERS]) for key in pair.keys}
    dof = float(bench.dof().sum())

    def by_itself(key: str) -> Explanation:
        others = [other for other in beside[key].keys if other != key]
        bare = beside[key].refit.stripped(model, others)
        reached = alone.get(key, math.inf) * dof
        (again,) = refit(model, bench, [bare.point], [bare.free], hopeless=1.0, reached=reached)
        return Explanation((key,), promises[key], again)

    hidden = [key for key in beside if beside[key].refit.misfit < STRONG * alone.get(key, math.inf)]
    tried = model.side_by_side(by_itself, hidden)
    better = [e for e in tried if e.refit.misfit < alone.get(e.keys[0], math.inf)]
    return freed(model, bench, better) if better else []


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
    samples = float(bench.dof().sum())
    accounts = [_account(model, e, floor, np.unique(bench.run)) for e in found]
    judgement = judge(
        nominal.misfit / floor,
        accounts,
        samples,
        inflation,
        list(model.shelf.effects),
        aliases(model, first),
    )
    return Attribution(nominal, tuple(found), first, judgement, inflation, floor, samples)


def _inflation(bench: Bench, seen: Screen) -> float:
    """By how much scores vary more than white residuals say; friction that scatters does so in step for a
    good part of a lane, and may for more than one."""
    pieces = PIECES_A_LANE * len(bench.lanes)
    return max(seen.inflation, float(bench.dof().sum()) / pieces if bench.scatters else 1.0)


def _account(model: Model, explanation: Explanation, floor: float, runs: np.ndarray) -> Account:
    """The account of an explanation on some runs. A strength that every run has of its own counts once, and
    for the other runs as far as these differ from one another."""
    keys, fit = explanation.keys, explanation.refit
    parameters, of_one_run = 0, 0.0
    for number in np.concatenate([model.of(key) for key in keys]):
        parameters += 1
        if number in model.by_run:
            own = fit.point.by_run[np.ix_(runs, model.slots(np.array([number])))]
            of_one_run += (len(runs) - 1) * float(np.var(own) / max(np.mean(own**2), 1e-300))
    return Account(keys, fit.misfit / floor, parameters, of_one_run, len(runs))


def _pairs(
    model: Model,
    bench: Bench,
    found: Sequence[Explanation],
    around: Screen,
    shapes: Shapes,
    progress: Progress,
) -> list[Explanation]:
    """Two effects together, the best first: what promises most beside the best single effects (`around` is
    the screening beside the very best), and what does in the place of either of the best two."""
    leader = found[0].refit
    seconds = [e for e in found[1:LEADERS] if e.refit.misfit < RIVAL * leader.misfit]
    screens = [around, *(screen(model, bench, e.refit, shapes=shapes) for e in seconds)]
    pairs = [
        pair
        for base, beside in zip(found, screens, strict=False)
        for pair in contest(model, bench, base.refit, beside.ranked[:SECONDS], FINAL_PAIRS, progress)
    ]
    pairs = freed(model, bench, best_of(pairs), LEADERS)
    if pairs[0].refit.misfit >= STRONG * leader.misfit:
        return pairs
    others = [
        other
        for key in pairs[0].keys
        for other in second_look(model, bench, pairs, key, INSTEAD, shapes, progress)
    ]
    return freed(model, bench, best_of([*pairs, *others]), LEADERS)


def _with_still_friction(
    model: Model, bench: Bench, nominal: Refit, leader: Explanation, shapes: Shapes, progress: Progress
) -> list[Explanation]:
    """Explanations found from a nominal model whose friction may not wander: what changes from lane to lane
    with direction, place or time would else be taken for wandering, and refits that begin there stay there.

    Pairs are among them where friction wanders even under the leader, the best explanation so far, which may
    then owe to its wandering what a second effect does.
    """
    own = nominal.point.own.copy()
    own[:, START:] = 0.0
    point = dataclasses.replace(nominal.point, own=own, widths=np.full(OWN - START, LEAST))
    (still,) = refit(model, bench, [point], [nominal.free], wander=False)
    promises = screen(model, bench, still, shapes=shapes).ranked[:FINALISTS]
    found = contest(model, bench, still, promises, FINALISTS, progress, wander=False)
    best = min(found, key=lambda e: e.refit.misfit).refit
    if wanders(leader.refit) and hints(still.misfit, best.misfit):
        seconds = screen(model, bench, best, shapes=shapes).ranked[:SECONDS]
        found += contest(model, bench, best, seconds, FINAL_PAIRS, progress, wander=False)
    fits = refit(model, bench, [e.refit.point for e in found], [e.refit.free for e in found])
    return [dataclasses.replace(e, refit=fit) for e, fit in zip(found, fits, strict=True)]
