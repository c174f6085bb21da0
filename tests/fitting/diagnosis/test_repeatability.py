"""Lanes in step with the excitation, and what does not repeat itself between them."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.laying import cut_in_step
from fitting.diagnosis.repeatability import successive
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
