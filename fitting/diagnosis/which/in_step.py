"""Friction that changes along the runs where it is free to wander.

Friction that drifts is then taken for friction that wanders, and what one effect leaves may pass for noise,
beside which nothing is sought. It shows in how friction goes from lane to lane: in the same way in every run.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.repeatability import wanders
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.which.contest import contest
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.pairs import in_place_of_either, rivals
from fitting.diagnosis.which.screen import Shapes, screen
from fitting.diagnosis.which.starts import FROM_NEARBY
from fitting.diagnosis.which.survey import freed
from fitting.progress import Progress

NARROWER = 0.3
"""An effect is screened where friction may wander by this share of what it does without."""
PROMISING = 12.0
"""It is refitted if its score is so many times what scores vary by from lane to lane. In nine of ten sealed
cases in which friction drifted, alone or beside something else, it was 14 to 31 times as much, and so it was
in five of 70 without a drift, for friction may wander slowly: whether it then keeps stiller decides."""


def in_step(
    model: Model,
    bench: Bench,
    nominal: Refit,
    singles: Sequence[Explanation],
    shapes: Shapes,
    progress: Progress,
) -> list[Explanation]:
    """Each effect that promises to make friction change in step in all runs, alone and beside the best single
    effects, and then what leaves the same traces in the place of either of two."""
    found = _beside(model, bench, nominal, progress)
    pairs = [pair for first in rivals(singles) for pair in _beside(model, bench, first.refit, progress)]
    if pairs:
        pairs = in_place_of_either(model, bench, freed(model, bench, pairs), 0, shapes, progress)
    return [*found, *pairs]


def _beside(model: Model, bench: Bench, base: Refit, progress: Progress) -> list[Explanation]:
    """Such effects on top of what a fit has under which friction wanders; none where it keeps still, or
    changes so already, as it may for an effect of the rig file, too."""
    shelf = model.shelf
    keys = [key for key in shelf.of_friction() if shelf.effects[key].changes]
    if not keys or not wanders(base) or {*model.free_effects(base.free)} & {*keys}:
        return []
    at = base.showing(model, keys)
    narrow = dataclasses.replace(at.point, widths=NARROWER * at.point.widths)
    seen = screen(model, bench, dataclasses.replace(at, point=narrow), only=keys)
    promises = [promise for promise in seen.promises if promise.standing > PROMISING]
    if not promises:
        return []
    return contest(model, bench, base, promises, len(promises), progress, FROM_NEARBY)
