"""Whether an effect acts alike from the beginning of the runs to their end.

Two clocks that run apart look like a delay that grows, a spring that warms up like a stiffness that is wrong
by more and more. An effect of the shelf does not change so, but for those that are about it. A score test for
a coefficient that changes in proportion to time (Nyblom, Journal of the American Statistical Association 84
(1989) 223), lanes being the clusters (Boos, The American Statistician 46 (1992) 327).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.layout import strengths_of
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.refits.scores import Projected, Table, places_of, templates_of
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly

CHANCE = 1e-3
"""The probability with which any of the strengths that are tested would change so by chance, were lanes
independent of one another; those of a run are not quite, where friction scatters slowly."""
SMALL_PART = 0.05
"""A change from the middle of the runs to their end by a smaller share of the strength itself may be owed to
the shape of the effect, or of another that acts as well. In two sealed cases in which nothing changed so it
was 1 and 3 %, in one of two clocks 8 %, in nine others of clocks and springs 32 % and more."""
NOTABLE = 200.0
"""By so much chi-square is to fall, too: where a few lanes carry most of a score, these may agree by chance.
In sealed cases whose clocks ran apart, or whose spring warmed up, it fell by 400 and more; in 30 others by no
more than 31, and in one by 107, of which one lane that touched an end stop had a third."""


@dataclasses.dataclass(frozen=True)
class Trend(AbstractAnomaly):
    """An effect (`title`: as sentences name it) that would have to change along the runs: by how much that
    lowers chi-square, as noise alone would have it and over what scores vary by from lane to lane; and
    whether it grows."""

    key: str
    title: str
    gain: float
    evidence: float
    grows: bool

    @property
    def clause(self) -> str:
        return f"what looks like {self.title} changes from the beginning of the runs to their end"

    @property
    def note(self) -> str:
        return (
            f"{self.key} would have to {'grow' if self.grows else 'shrink'} along the runs (chi-square "
            f"{self.evidence:.3g} by segments, one degree of freedom), which it does not on the shelf: look "
            "for two clocks that run apart if it is a delay, else for something that warms up, wears or "
            "works loose."
        )

    @property
    def look(self) -> str:
        return (
            "Record the same run twice in a row, and once more after a long pause: what warms up goes on in "
            "the second and begins anew after the pause, what wears goes on in both, and two clocks that run "
            "apart begin anew with every record."
        )


def trend_of(model: Model, bench: Bench, at: Refit, keys: Sequence[str]) -> Trend | None:
    """The effect of these that most surely changes along the runs, at a fit with or without it, of those of
    which that is news; None where none surely does."""
    present = set(model.free_effects(at.free))
    lasting = {key for key in keys if not model.shelf.effects[key].changes}
    groups = [tuple(key for key in group if key in lasting) for group in model.sharing.groups]
    groups = [group for group in groups if group]
    ordered = [key for group in groups for key in group]
    if not ordered:
        return None
    common, (still,) = templates_of(model, bench, at, groups, [at.point.coordinates])
    time = _along(bench)[:, None, None]
    columns = still.beside(Projected(*(values * time for values in still)))
    table, count = Table(model, bench, at, common, columns), still.columns.shape[2]
    surely = float(chi2.isf(CHANCE / count, 1))
    found = []
    for key, place in zip(ordered, places_of(model, bench, ordered), strict=True):
        fitted = strengths_of(model, bench, at.point, key) if key in present else None
        others = place if fitted is None else place[:0]
        for number, own in enumerate(place):
            change = _Change.of(table, common, columns, np.array([own + count, *others]))
            strengths = change.others if fitted is None else fitted
            if abs(change.amount) < SMALL_PART * float(np.abs(strengths).max()):
                continue
            grows = bool(strengths[number] * change.amount > 0)
            found.append(Trend(key, model.shelf.titled(key), change.gain, change.evidence, grows))
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


class _Change(NamedTuple):
    """What the first of some columns gains where the others of these places are free as well: its amount,
    theirs, the fall of chi-square, and that over what scores vary by from lane to lane where all have been
    let free."""

    amount: float
    others: np.ndarray
    gain: float
    evidence: float

    @classmethod
    def of(cls, table: Table, common: Projected, columns: Projected, place: np.ndarray) -> _Change:
        first, rest = place[0], place[1:]
        amounts = np.linalg.solve(table.information(place), -table.gram[place, -1])
        room = np.linalg.solve(table.information(rest), table.gram[rest, first])
        information = float(table.information(place[:1])[0, 0] - room @ table.gram[rest, first])
        base = common.columns[:, :, :-1]
        own, answers = columns.columns[:, :, place], table.answers[:, :, place]
        alone = own + base @ answers
        alone = alone[:, :, 0] - alone[:, :, 1:] @ room
        moved = table.answers[:, :, -1] + answers @ amounts
        left = common.columns[:, :, -1] + own @ amounts + np.einsum("lrb,lb->lr", base, moved)
        scores = np.einsum("lr,lr->l", alone, left)
        gain, spread = float(amounts[0] ** 2 * information), max(float(scores @ scores), 1e-300)
        return cls(float(amounts[0]), amounts[1:], gain, gain * information / spread)
