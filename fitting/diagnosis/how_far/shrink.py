"""How far the gap shrinks, on runs or segments that took no part in choosing or fitting."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Sequence

import numpy as np

from fitting.cycle import frequency_of
from fitting.diagnosis.findings import Closure
from fitting.diagnosis.how_far.elsewhere import elsewhere
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.cost import misfit_of, significance
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.steadiness import steadier
from fitting.diagnosis.noise.repeatability import unrepeated
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.refits.release import released
from fitting.problem import Problem
from jaxstick.record import CONSTANTS

BLOCK = 4
"""Lanes are held out, and drawn anew, in stretches of so many."""
DRAWS = 400
FEWEST_RUNS = 4
FLOOR_KNOWN = 0.04
"""Standard deviation of the floor as a share of it, and where nearly all of a gap is closed that is most of
the doubt: in 122 sealed cases whose formulas are the shelf's, what the right verdict left lay so far around
the noise (0.038 where that is estimated from the records, more where it is stated)."""
LEAST_REDUCIBLE = 0.02
GAPING, OPEN = 1.5, 0.3
"""A gap of more than so many times its floor is there to be closed; a cause closes more than this share,"""
ONLY_HERE = 1.2
"""A gap of so many times its floor is more than noise where what was fitted shows none."""
NOTABLE_GAP = 1.1
"""A gap of less than so many times its floor may be noise that is not known better."""
CLEARLY = 1.003
"""What makes a gap so many times as large makes it worse by more than chance: of 182 sealed cases in which an
effect was named two that were off the shelf did, and none in which the right one was."""
CARRIES_OVER = 0.5
"""or helps the typical segment by this share of what it did where it was fitted: a few segments that
something else spoils may keep a gap open."""
NOTABLE_STEADINESS = 2.0
"""Logarithm of a likelihood ratio from which on friction is said to keep stiller."""


@dataclasses.dataclass(frozen=True)
class Split:
    """Which lanes are fitted and which are held out; the files held out whole (none where stretches are)."""

    fitted: np.ndarray
    held: np.ndarray
    files: tuple[str, ...]

    @property
    def by_segments(self) -> bool:
        return not self.files


def split(problem: Problem, bench: Bench, hold_out: Sequence[str], fitted: Collection[str] = ()) -> Split:
    """Holds out the named runs; else a third of the runs; with fewer than four, every third stretch of lanes.

    Among the runs that are fitted are the slowest, the fastest and the one of the largest stroke, so that
    what is held out asks for nothing beyond what was seen: an end stop, say, may act in one run alone. Those
    asked to be `fitted` are so in any case, and the extreme ones where others are left. A run without a
    frequency, stated or seen, is as slow as any.
    """
    runs = [signal.run for signal in problem.chosen]
    files = [run.file for run in runs]
    named = tuple(dict.fromkeys(hold_out))
    if not named and len(files) >= FEWEST_RUNS:
        order = sorted(range(len(files)), key=lambda n: frequency_of(runs[n]) or 0.0)
        longest = max(order, key=lambda n: float(np.ptp(runs[n].displacement)))
        free = [n for n in order if files[n] not in fitted]
        inner = [n for n in free if n not in (order[0], order[-1], longest)] or free
        count = min(round(len(order) / 3), len(inner))
        named = tuple(files[inner[(2 * k + 1) * len(inner) // (2 * count)]] for k in range(count))
    if not named:
        stretch = np.array([lane // BLOCK for lane in range(len(bench.run))])
        held = np.flatnonzero(stretch % 3 == 1)
        return Split(np.setdiff1d(np.arange(len(bench.run)), held), held, ())
    numbers = [files.index(name) for name in named]
    mask = np.isin(bench.run, numbers)
    return Split(np.flatnonzero(~mask), np.flatnonzero(mask), named)


def closure(
    problem: Problem,
    model: Model,
    bench: Bench,
    held: Split,
    fits: dict[str, Refit],
    own: np.ndarray,
    seed: int,
) -> Closure:
    """The gap on the held-out lanes under several fits of the others: `fits` has those called nominal and
    named, and may have rival, wrong and placebo.

    Constants and effects stay as fitted; every lane's start, at first by itself, and what every run has of
    its own, its level of friction for one, are fitted anew. Friction may wander as far as it does under the
    named fit. The floor is what does not repeat itself from cycle to cycle, the noise where nothing repeats.
    """
    test, widths = bench.take(held.held), fits["named"].point.widths
    points = {
        name: dataclasses.replace(fit.point, own=own[held.held], widths=widths) for name, fit in fits.items()
    }
    assumed = {name: getattr(problem.dataset.assumed, name) for name in CONSTANTS}
    if all(value is not None for value in assumed.values()):
        point = Point((), model.origin(assumed), model.alike(test.runs), own[held.held], widths)
        points["assumed"] = point
    frees = [fits[name].free if name in fits else np.zeros(0, int) for name in points]
    frees = [free[np.isin(free, model.by_run)] for free in frees]
    results = dict(zip(points, elsewhere(model, test, list(points.values()), frees), strict=True))
    compared = [name for name in ("nominal", "named", "rival") if name in fits]
    again = model.side_by_side(lambda name: released(model, test, results[name], wander=False), compared)
    results.update(zip(compared, again, strict=True))
    dof = test.dof()
    gaps = {name: math.sqrt(misfit_of(result.cost, dof)) for name, result in results.items()}
    repeated = unrepeated(model, test, again[:2])
    floor = min(math.sqrt(repeated), gaps["named"])

    def closed(name: str) -> float:
        return share_closed(gaps["nominal"], gaps[name], floor)

    def steadied(name: str) -> float:
        return steadier(results["nominal"].levels, results[name].levels, test.run)

    costs = {name: results[name].cost for name in compared}
    return Closure(
        before=gaps["nominal"],
        after=gaps["named"],
        floor=floor,
        assumed=gaps.get("assumed"),
        closed=closed("named"),
        interval=closed_interval(costs["nominal"], costs["named"], dof, floor, seed),
        placebo=closed("placebo") if "placebo" in gaps else None,
        wrong=closed("wrong") if "wrong" in gaps else None,
        held_out=held.files,
        by_segments=held.by_segments,
        gain=gain(results["nominal"], results["named"]),
        steadier=steadied("named"),
        rival=steadied("rival") if "rival" in fits else None,
        significance=significance(costs["nominal"] - floor**2 * dof),
    )


def gain(nominal: Refit, named: Refit) -> float:
    """The mean logarithm of how many times less a lane costs."""
    return float(np.mean(np.log(nominal.cost / named.cost)))


def stays_open(shrunk: Closure, gaping: float = GAPING) -> bool:
    """Whether a gap of more than `gaping` times its floor is there and is not closed."""
    return shrunk.before > gaping * shrunk.floor and shrunk.interval[1] < OPEN


def shows_more(shrunk: Closure) -> bool:
    """Whether what took no part shows more than noise beside what is named."""
    return shrunk.after > ONLY_HERE * shrunk.floor


def closes(shrunk: Closure) -> bool:
    """Whether a gap that is more than noise closes on what took no part, and by more than chance."""
    return shrunk.before > NOTABLE_GAP * shrunk.floor and shrunk.interval[0] > OPEN


def refutes(shrunk: Closure, gained: float) -> bool:
    """Whether what took no part speaks against what is named: a gap stays open, and segments gain less than
    half of what those have `gained` that were fitted."""
    return stays_open(shrunk) and shrunk.gain < CARRIES_OVER * gained


def steadies(shrunk: Closure, steadied: float) -> bool:
    """Whether what is named is so since friction keeps stiller with it, in what was fitted (`steadied`) and
    all in all: an effect that would be taken for wandering closes no gap."""
    return min(steadied, steadied + shrunk.steadier) > NOTABLE_STEADINESS


def worsens(shrunk: Closure, by: float = 1.0) -> bool:
    """Whether what is named makes it worse on what took no part, where there is no gap to be closed, by more
    than so many times."""
    return shrunk.before <= GAPING * shrunk.floor and shrunk.after > by * shrunk.before


def left_open(shrunk: Closure) -> Closure:
    """The same gaps with nothing named."""
    return dataclasses.replace(
        shrunk,
        after=shrunk.before,
        floor=min(shrunk.floor, shrunk.before),
        closed=0.0,
        interval=(0.0, 0.0),
        placebo=None,
        wrong=None,
        wrong_keys=(),
    )


def share_closed(before: float, after: float, floor: float) -> float:
    """(before - after)/(before - floor); 0 where next to nothing can be closed."""
    reducible = before - floor
    return (before - after) / reducible if reducible > LEAST_REDUCIBLE else 0.0


def closed_interval(
    before: np.ndarray, after: np.ndarray, dof: np.ndarray, floor: float, seed: int
) -> tuple[float, float]:
    """95 % interval of the share closed, by drawing stretches of lanes anew (block bootstrap), and the floor
    as far as it is known."""
    random = np.random.default_rng(seed)
    floors = floor * (1 + FLOOR_KNOWN * random.standard_normal(DRAWS))
    blocks = np.array_split(np.arange(len(before)), max(1, len(before) // BLOCK))
    if len(blocks) < 2:
        blocks = [np.array([lane]) for lane in range(len(before))]
    found = []
    for drawn_floor in floors.tolist():
        drawn = np.concatenate([blocks[i] for i in random.integers(len(blocks), size=len(blocks))])
        gaps = [math.sqrt(misfit_of(cost[drawn], dof[drawn])) for cost in (before, after)]
        found.append(share_closed(gaps[0], gaps[1], drawn_floor))
    low, high = np.quantile(found, [0.025, 0.975])
    return float(low), float(high)
