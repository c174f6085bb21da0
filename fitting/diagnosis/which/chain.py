"""Two links of the measuring chain, the other way round: a force that is clipped before a hum comes to it
shows another record than one that is clipped with the hum on it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from fitting.diagnosis.judging.enough import passes_for_noise
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.which.contest import contest
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.screen import Screen
from fitting.diagnosis.which.survey import freed
from fitting.progress import Progress

TRIED, FINALISTS = 5, 2
"""So many links are tried on the other side of the one that explains most, so many of these to the end."""


def other_way_round(
    model: Model, bench: Bench, pairs: Sequence[Explanation], floor: float
) -> list[Explanation]:
    """The pairs of which both are links of the measuring chain and which leave more than noise above the
    `floor`, with the links in the other order, where they leave less so."""
    effects = model.shelf.effects
    chains = [e for e in pairs if len(e.keys) == 2 and all(effects[key].on_chain() for key in e.keys)]
    chains = [e for e in chains if not passes_for_noise(e.refit.misfit / floor)]
    if not chains:
        return []
    points = [_turned(e) for e in chains]
    fits = refit(model, bench, points, [e.refit.free for e in chains], hopeless=1.0)
    tried = [e.fitted(fit) for e, fit in zip(chains, fits, strict=True)]
    better = [new for new, old in zip(tried, chains, strict=True) if new.refit.misfit < old.refit.misfit]
    return freed(model, bench, better) if better else []


def on_the_other_side(
    model: Model, bench: Bench, one: Explanation, around: Screen, progress: Progress
) -> list[Explanation]:
    """Pairs, the best first, of a link of the measuring chain with others that stand on the other side of it
    than in the order of the shelf, where these may show next to nothing: the play of a hysteresis, say, is
    wide open to a force that has a hum on it already. `around`: the screening beside the one in that order.
    None where that one is no link."""
    links = [key for key in model.sharing.whole if model.shelf.effects[key].on_chain()]
    (known,) = one.keys
    if known not in links:
        return []
    place = links.index(known)
    turned = (*links[place + 1 :], known, *links[:place])
    begin = dataclasses.replace(one.refit, point=dataclasses.replace(one.refit.point, turned=turned))
    promises = [promise for promise in around.ranked if promise.key in links][:TRIED]
    if not promises:
        return []
    found = contest(model, bench, begin, promises, FINALISTS, progress)
    return freed(model, bench, [pair.fitted(_only_these_turned(pair)) for pair in found])


def _only_these_turned(pair: Explanation) -> Refit:
    point = pair.refit.point
    return dataclasses.replace(pair.refit, point=dataclasses.replace(point, turned=point.acting(pair.keys)))


def _turned(pair: Explanation) -> Point:
    point = pair.refit.point
    return dataclasses.replace(point, turned=point.acting(pair.keys)[::-1])
