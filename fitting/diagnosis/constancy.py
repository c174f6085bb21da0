"""Whether an effect acts alike from the beginning of the runs to their end.

Two clocks that run apart look like a delay that grows, a spring that warms up like a stiffness that is wrong
by more and more. An effect of the shelf does not change so, but for those that are about it, which are
screened with the rest. A score test for a coefficient that changes in proportion to time (Nyblom, Journal of
the American Statistical Association 84 (1989) 223), lanes being the clusters (Boos, The American Statistician
46 (1992) 327).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.stats import chi2

from fitting.diagnosis.bench import Bench
from fitting.diagnosis.layout import strengths_of
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import Refit
from fitting.diagnosis.scores import Projected, Table, places_of, templates_of

CHANCE = 0.01
"""The probability with which any of the strengths that are tested would change so by chance."""
NOTABLE = 50.0
"""By so much chi-square is to fall, too: lanes are few, and scores of a few lanes may agree by chance. Of
sealed cases those whose clocks ran apart, or whose spring warmed up, gained 400 to 10000; no other more
than 40."""


@dataclasses.dataclass(frozen=True)
class Trend:
    """An effect that would have to change along the runs: by how much that lowers chi-square, as noise alone
    would have it and over what scores vary by from lane to lane; and whether it grows."""

    key: str
    gain: float
    evidence: float
    grows: bool


def trend_of(model: Model, bench: Bench, at: Refit, keys: Sequence[str]) -> Trend | None:
    """The effect of these that most surely changes along the runs, at a fit with or without it; None where
    none surely does."""
    present = set(model.free_effects(at.free))
    groups = [tuple(key for key in group if key in keys) for group in model.groups()]
    groups = [group for group in groups if group]
    ordered = [key for group in groups for key in group]
    common, (still,) = templates_of(model, bench, at, groups, [at.point.coordinates])
    time = _along(bench)[:, None, None]
    moving = Projected(*(values * time for values in still))
    count = still.columns.shape[2]
    table = Table(model, bench, at, common, still.beside(moving))
    surely = float(chi2.isf(CHANCE / count, 1))
    found = []
    for key, place in zip(ordered, places_of(model, bench, ordered), strict=True):
        if key in present:
            mean = strengths_of(model, bench, at.point, key)
            found += _changing(table, key, place[:0], place + count, mean)
        else:
            found += _changing(table, key, place, place + count)
    found = [trend for trend in found if trend.gain > NOTABLE and trend.evidence > surely]
    return max(found, key=lambda trend: trend.evidence, default=None)


def _along(bench: Bench) -> np.ndarray:
    """When a lane begins, from -1 for the first of its run to 1 for the last."""
    begins = np.asarray(bench.lanes.start_time, float)
    out = np.zeros(len(begins))
    for run in np.unique(bench.run):
        mine = bench.run == run
        first, last = begins[mine].min(), begins[mine].max()
        out[mine] = (2 * begins[mine] - first - last) / max(last - first, 1e-300)
    return out


def _changing(
    table: Table, key: str, still: np.ndarray, moving: np.ndarray, mean: np.ndarray | None = None
) -> list[Trend]:
    """What changes of an effect's strengths gain, each by itself, where the strengths are free besides: the
    places of their columns, and of those that change. `mean`: the strengths where they have been fitted."""
    room = np.linalg.solve(table.information(still), table.gram[np.ix_(still, moving)])
    pull = room.T @ table.gram[still, -1] - table.gram[moving, -1]
    curvature = np.diag(table.information(moving) - room.T @ table.gram[np.ix_(still, moving)])
    by_lane = table.by_lane[:, moving] - table.by_lane[:, still] @ room
    change = pull / curvature
    if mean is None:
        alone = np.linalg.solve(table.information(still), -table.gram[still, -1])
        mean = alone - np.diag(room) * change
    evidence = pull**2 / np.maximum(np.sum(by_lane**2, axis=0), 1e-300)
    return [
        Trend(key, float(gain), float(sure), bool(grows))
        for gain, sure, grows in zip(pull * change, evidence, mean * change > 0, strict=True)
    ]
