"""What runs that took no part say of what is named."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from fitting.diagnosis.findings import Closure
from fitting.diagnosis.how_far.shrink import (
    FEWEST_RUNS,
    FLOOR_KNOWN,
    closed_interval,
    left_open,
    refutes,
    split,
    steadies,
    worsens,
)
from jaxstick.record import KnownRig, Run

CLOSED = Closure(6.6, 1.1, 1.0, 14.0, 0.98, (0.95, 1.0), -0.02, 0.4, ("run-02.csv",), False)


def divided(
    frequencies: list[float],
    strokes: list[float],
    hold_out: tuple[str, ...] = (),
    fitted: tuple[str, ...] = (),
) -> list[int]:
    """Which runs of these frequencies [Hz] and strokes are held out, each of two lanes."""
    signals = [
        SimpleNamespace(run=SimpleNamespace(file=str(n), frequency=f, displacement=np.array([0.0, stroke])))
        for n, (f, stroke) in enumerate(zip(frequencies, strokes, strict=True))
    ]
    problem: Any = SimpleNamespace(chosen=signals)
    bench: Any = SimpleNamespace(run=np.repeat(np.arange(len(signals)), 2))
    found = split(problem, bench, hold_out, fitted)
    assert sorted([*found.fitted, *found.held]) == list(range(2 * len(signals)))
    assert sorted(bench.run[found.held]) == sorted(2 * [int(file) for file in found.files])
    return [int(file) for file in found.files]


@given(
    some.lists(some.tuples(some.floats(0.1, 10.0), some.floats(1e-3, 0.1)), min_size=FEWEST_RUNS, max_size=20)
)
def test_what_is_held_out_lies_within_what_is_fitted(runs):
    """A third of the runs, none twice, but not the slowest, the fastest or that of the largest stroke."""
    frequencies, strokes = ([run[place] for run in runs] for place in (0, 1))
    held = divided(frequencies, strokes)
    assert len({*held}) == len(held) == round(len(runs) / 3)
    fitted = [n for n in range(len(runs)) if n not in held]
    for every in (frequencies, strokes):
        assert max(every[n] for n in fitted) == max(every)
    assert min(frequencies[n] for n in fitted) == min(frequencies)


def test_the_frequency_of_a_base_that_is_recorded_need_not_be_stated():
    """In whatever order the runs come."""
    time = np.linspace(0.0, 6.0, 1200)
    order = [2.9, 0.7, 1.3, 4.1, 0.4, 2.2]
    signals = [
        SimpleNamespace(
            run=Run(
                file=str(frequency),
                rig=KnownRig(2.38, 1986.0, 1986.0, 4.53, 0.0),
                time=time,
                displacement=0.01 * np.sin(2 * np.pi * frequency * time),
                base=0.01 * np.sin(2 * np.pi * frequency * time),
            )
        )
        for frequency in order
    ]
    problem: Any = SimpleNamespace(chosen=signals)
    bench: Any = SimpleNamespace(run=np.arange(len(signals)))
    held = [float(file) for file in split(problem, bench, ()).files]
    assert len(held) == 2 and min(held) > min(order) and max(held) < max(order)


@given(
    some.lists(some.tuples(some.floats(0.1, 10.0), some.floats(1e-3, 0.1)), min_size=FEWEST_RUNS, max_size=20)
)
def test_others_are_held_out_in_the_place_of_those_that_were(runs):
    """As many, where there are so many besides the extreme ones; one at least."""
    frequencies, strokes = ([run[place] for run in runs] for place in (0, 1))
    before = divided(frequencies, strokes)
    instead = divided(frequencies, strokes, fitted=tuple(map(str, before)))
    assert not {*before} & {*instead}
    assert len({*instead}) == len(instead) and 1 <= len(instead) <= len(before)


def test_runs_that_are_named_are_held_out():
    assert divided([1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 1.0, 1.0], ("3", "1", "3")) == [3, 1]


@pytest.mark.parametrize(
    ("before", "floor", "closed", "interval", "refuted"),
    [
        (6.6, 1.0, 0.98, (0.95, 1.0), False),
        (6.6, 1.4, 0.12, (0.07, 0.17), True),
        (4.4, 1.0, -0.80, (-1.2, -0.41), True),
        (6.6, 1.0, 0.12, (-0.30, 0.55), False),
        (1.2, 1.0, 0.00, (-0.10, 0.10), False),
        (6.6, 5.9, 0.00, (-0.10, 0.10), False),
    ],
    ids=["closed", "open", "wider", "uncertain", "no gap", "a gap that nothing closes"],
)
def test_a_gap_that_stays_open_refutes(before, floor, closed, interval, refuted):
    shrunk = dataclasses.replace(CLOSED, before=before, floor=floor, closed=closed, interval=interval)
    assert refutes(shrunk, 1.0) is refuted
    assert not refutes(dataclasses.replace(shrunk, gain=0.6), 1.0)


@pytest.mark.parametrize(
    ("before", "after", "worse"),
    [(0.990, 0.994, True), (0.994, 0.990, False), (1.4, 1.41, True), (6.6, 6.7, False)],
    ids=["noise, more of it", "noise, less of it", "hardly a gap", "a gap"],
)
def test_what_makes_noise_no_less_worsens(before, after, worse):
    """A gap that stays open is another matter."""
    shrunk = dataclasses.replace(CLOSED, before=before, after=after)
    assert worsens(shrunk) is worse
    assert worsens(shrunk, 1.0001) is worse and not worsens(shrunk, 1.05)


def test_with_nothing_named_nothing_closes():
    shrunk = left_open(dataclasses.replace(CLOSED, wrong_keys=("sticky",)))
    assert (shrunk.before, shrunk.floor, shrunk.assumed) == (CLOSED.before, CLOSED.floor, CLOSED.assumed)
    assert left_open(dataclasses.replace(CLOSED, before=0.93, floor=0.94)).floor == 0.93
    assert (shrunk.after, shrunk.closed, shrunk.interval) == (CLOSED.before, 0.0, (0.0, 0.0))
    assert shrunk.placebo is None and shrunk.wrong is None and shrunk.wrong_keys == ()


@pytest.mark.parametrize(
    ("steadier", "steadied", "stiller"),
    [(6.0, 8.0, True), (0.5, 8.0, True), (-7.0, 8.0, False), (6.0, 1.5, False)],
)
def test_friction_that_keeps_stiller_does_so_all_in_all(steadier, steadied, stiller):
    assert steadies(dataclasses.replace(CLOSED, steadier=steadier), steadied) is stiller


@pytest.mark.parametrize("after", [1.0, 1.04])
def test_the_share_closed_is_known_no_better_than_its_floor(after):
    """All lanes alike, so that drawing them anew changes nothing: S = (b - a)/(b - f), and f is known to a
    fortieth. A gap closed to the noise may be closed entirely, and by no more than that allows."""
    dof, before = np.full(40, 100.0), 3.0
    low, high = closed_interval(before**2 * dof, after**2 * dof, dof, 1.0, 0)
    share = (before - after) / (before - 1.0)
    reach = 1.96 * share * FLOOR_KNOWN / (before - 1.0)
    assert low == pytest.approx(share - reach, abs=0.2 * reach)
    assert high == pytest.approx(share + reach, abs=0.2 * reach) and high > 1.0


def test_a_gap_that_closes_up_to_noise_which_is_not_known_better_may_close_all():
    """What is left of it lies six percent above the floor, as in some cases whose very effect was named."""
    dof = np.full(40, 100.0)
    low, high = closed_interval(dof * 1.9**2, dof * 1.06**2, dof, 1.0, 0)
    assert low < 0.9 and high >= 1.0
