"""Runs that might be recorded next, and what their records would show."""

from __future__ import annotations

import math
from collections.abc import Sequence

import equinox as eqx
import numpy as np

from fitting.diagnosis.findings import Plan
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit
from fitting.problem import Problem
from fitting.signals import Signals, read_signals
from jaxstick.cycle import cycle_of
from jaxstick.hypothesis import Hypothesis
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Noise, Run
from jaxstick.side_by_side import Journey, side_by_side

FREQUENCIES = 7
BEYOND = 1.5
"""So many frequencies are tried, from the lowest recorded over this factor to the highest times it,"""
AMPLITUDES = (0.5, 1.0, 2.0)
"""each with so many times the amplitude that was recorded around it."""
CYCLES = 2.0
SAMPLES = 20.0
"""A run holds so many cycles at least, and a cycle so many samples."""
SETTLING = 12.0
"""Natural periods, or cycles where these are longer, that a run has behind it when its record begins."""


def plans(problem: Problem) -> list[Plan]:
    """Runs of other frequencies and amplitudes than the recorded ones, near enough to them to be possible;
    none where no recorded run is driven by a sine."""
    known = [plan for signal in problem.chosen if (plan := _plan(signal)) is not None]
    if not known:
        return []
    by_force = known[0].by_force
    known = sorted(plan for plan in known if plan.by_force == by_force)
    frequency = np.array([plan.frequency for plan in known])
    amplitude = np.array([plan.amplitude for plan in known])
    interval, lasting = _sampling(problem)
    lowest = max(frequency[0] / BEYOND, CYCLES / lasting)
    highest = min(frequency[-1] * BEYOND, 1 / (SAMPLES * interval))
    if not lowest < highest:
        return []
    tried = np.geomspace(lowest, highest, FREQUENCIES)
    around = np.exp(np.interp(np.log(tried), np.log(frequency), np.log(amplitude)))
    return [
        Plan(float(f), float(share * a), by_force)
        for f, a in zip(tried, around, strict=True)
        for share in AMPLITUDES
    ]


def _plan(signal: Signals) -> Plan | None:
    cycle = cycle_of(signal.run)
    if cycle is None or not (amplitude := cycle.base_amplitude or cycle.force_amplitude):
        return None
    return Plan(cycle.frequency, amplitude, by_force=cycle.force_amplitude > 0)


def _sampling(problem: Problem) -> tuple[float, float]:
    """Interval and duration [s] of a run like the recorded ones."""
    runs = [signal.run for signal in problem.chosen]
    interval = float(np.median([run.interval for run in runs]))
    return interval, float(np.median([run.interval * len(run.time) for run in runs]))


def recorded(problem: Problem, model: Model, fit: Refit, tried: Sequence[Plan]) -> tuple[Signals, ...]:
    """What the channels of the recorded runs would show of each plan, were a fit true and sensors free of
    noise."""
    interval, lasting = _sampling(problem)
    samples = round(lasting / interval)
    hypothesis = model.at(fit.point.coordinates, fit.point.attached)
    before = [math.ceil(SETTLING * max(problem.period, 1 / plan.frequency) / interval) for plan in tried]
    trajectories = side_by_side(
        [
            Journey(_driven(hypothesis, plan), Start(), 0.0, interval, first + samples)
            for plan, first in zip(tried, before, strict=True)
        ]
    )
    noisy = [signal.friction_noise for signal in problem.chosen if signal.friction_noise is not None]
    noise = Noise(
        displacement=float(np.median([signal.displacement_noise for signal in problem.chosen])),
        friction=float(np.median(noisy)) if noisy else None,
    )
    found = []
    for plan, first, trajectory in zip(tried, before, trajectories, strict=True):
        time = np.asarray(trajectory.time)[first:]
        wave = plan.amplitude * np.sin(2 * math.pi * plan.frequency * time)
        run = Run(
            file="planned",
            time=time,
            displacement=np.asarray(trajectory.displacement)[first:],
            friction=np.asarray(trajectory.friction)[first:] if noisy else None,
            force=wave if plan.by_force else None,
            frequency=plan.frequency,
            base_amplitude=None if plan.by_force else plan.amplitude,
            rig=problem.dataset.rig,
        )
        found.append(read_signals(run, noise))
    return tuple(found)


def _driven(hypothesis: Hypothesis, plan: Plan) -> Oscillator:
    sizes = {"force_amplitude" if plan.by_force else "base_amplitude": plan.amplitude}
    drive = SineDrive(plan.frequency, **sizes)
    return eqx.tree_at(lambda whole: whole.nominal.drive, hypothesis, drive).oscillator()
