"""Lanes in step with the excitation, and what does not repeat itself between them."""

from __future__ import annotations

import dataclasses
import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.columns import Columns
from fitting.diagnosis.lanes.laying import cut_in_step
from fitting.diagnosis.lanes.steadiness import Levels
from fitting.diagnosis.lanes.wander import OWN
from fitting.diagnosis.noise.repeatability import UNEVEN, floor_of, successive, unrepeated
from fitting.diagnosis.refits.refit import Refit
from fitting.signals import read_signals
from jaxstick.record import KnownRig, Noise, Run


def run(samples: int, cycle: float, stated: bool = True) -> Run:
    """A run whose excitation has `cycle` samples a cycle."""
    time = 0.002 * np.arange(samples)
    wave = 1e-3 * np.sin(2 * np.pi * np.arange(samples) / cycle)
    frequency = 1 / (0.002 * cycle) if stated else None
    return dataclasses.replace(_blank(time, wave), frequency=frequency)


def _blank(time: np.ndarray, wave: np.ndarray) -> Run:
    rig = KnownRig(2.38, 1986.0, 1986.0, 4.53, 0.0)
    return Run(file="run-01.csv", rig=rig, time=time, displacement=wave, base=wave)


@pytest.mark.parametrize("stated", [True, False])
@given(st.integers(300, 900), st.floats(20.0, 400.0))
def test_segments_cover_every_run_and_keep_step(stated, samples, cycle):
    signals = [read_signals(run(samples, cycle, stated), Noise(1e-6, None))]
    segments, phases = cut_in_step(signals, 96)
    assert segments[0].first == 0 and segments[-1].last == samples
    assert all(a.last == b.first for a, b in itertools.pairwise(segments))
    assert all(0 < s.last - s.first <= 96 for s in segments)
    first, second = successive(np.array(phases))
    for one, other in zip(first, second, strict=True):
        cycles = (segments[other].first - segments[one].first) / cycle
        assert cycles >= 0.9
        assert cycles == pytest.approx(round(cycles), abs=2.0 / cycle)


def test_successive_lanes_of_a_phase_are_paired():
    first, second = successive(np.array([0, 1, 0, 1, -1, 0, 2, -1]))
    assert (first.tolist(), second.tolist()) == ([0, 1, 2], [2, 3, 5])
    assert len(successive(np.array([-1, -1, 3]))[0]) == 0


LANES, COUNTED = 24, 50


def judged(
    residual: np.ndarray, cost: float, width: float, price: float = 1.0, phases: int = 1, wanders: bool = True
) -> float:
    """The floor that residuals (lanes, samples) of lanes with so many phases lead to, at this cost per degree
    of freedom and friction that wanders by this width, if it may, at this price; without the price it is
    lower by that."""
    blank = np.zeros_like(residual)
    lanes: Any = None
    share = np.stack([np.ones_like(residual), blank], axis=2)
    bench = Bench(lanes, np.zeros(LANES, int), 1, share, np.arange(LANES) % phases, wanders)
    rows = np.concatenate([residual, blank, np.zeros((LANES, OWN))], axis=1)
    model: Any = SimpleNamespace(columns=lambda jobs: [Columns(rows, rows, rows) for _ in jobs])
    point = Point((), np.zeros(1), np.zeros((1, 1)), np.zeros((LANES, OWN)), np.full(2, width))
    each = np.full(LANES, cost * (COUNTED - 3))
    levels = Levels(np.zeros(LANES), np.ones(LANES), np.ones(LANES, bool))
    fit = Refit(point, np.zeros(0, int), each, price * cost, np.ones(LANES), 1, levels, {})
    floor, bare = floor_of(model, bench, [fit]), unrepeated(model, bench, [fit])
    assert bare == 1.0 or floor == pytest.approx(price * bare)
    return floor


def test_the_floor_is_what_changes_from_one_cycle_to_the_next(monkeypatch):
    """Residuals of 3 standard deviations that change, on top of a bias that does not."""
    monkeypatch.setattr("fitting.diagnosis.noise.repeatability.job", lambda model, bench, point: None)
    random = np.random.default_rng(3)
    residual = 50 * np.sin(np.arange(COUNTED)) + 3 * random.standard_normal((LANES, COUNTED))
    assert judged(residual, 1300.0, 0.02) == pytest.approx(9.0, rel=0.25)
    assert judged(residual, 1300.0, 0.02, 1.1) == pytest.approx(1.1 * judged(residual, 1300.0, 0.02))
    assert judged(residual, 1300.0, 1e-6) == 1.0


def test_the_floor_lies_no_higher_than_a_typical_lane(monkeypatch):
    """What acts in some lanes alone changes from cycle to cycle too, and is no noise."""
    monkeypatch.setattr("fitting.diagnosis.noise.repeatability.job", lambda model, bench, point: None)
    residual = 9 * np.random.default_rng(4).standard_normal((LANES, COUNTED))
    assert judged(residual, 1.4, 0.02) == pytest.approx(UNEVEN * 1.4)
    assert judged(residual, 0.4, 0.02) == 1.0


def test_without_a_force_channel_what_changes_is_no_floor_unless_it_can_be_told_from_a_drift(monkeypatch):
    """That takes four changes, five cycles, of a phase."""
    monkeypatch.setattr("fitting.diagnosis.noise.repeatability.job", lambda model, bench, point: None)
    residual = 3 * np.random.default_rng(5).standard_normal((LANES, COUNTED))
    for phases, floor in ((4, 9.0), (6, 1.0)):
        assert judged(residual, 1300.0, 1e-6, phases=phases, wanders=False) == pytest.approx(floor, rel=0.25)
        assert judged(residual, 1300.0, 1e-6, phases=phases) == 1.0
    drifting = np.arange(LANES)[:, None] * np.sin(np.arange(COUNTED))
    assert judged(drifting, 1300.0, 1e-6, phases=4, wanders=False) == pytest.approx(1.0, rel=0.05)
