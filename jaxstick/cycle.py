"""The sine that drives a run, and what the run's motion under it amounts to."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxstick.formats.harmonic import fit_harmonic
from jaxstick.outcome import Outcome, outcome
from jaxstick.record import Run

IMPURE = 0.05
"""A drive whose residual beside its best sine exceeds this share of the sine's effective value is none."""


@dataclass(frozen=True)
class Cycle:
    """base_amplitude sin(2 pi frequency t + phase) [m], or the like with force_amplitude [N]."""

    frequency: float
    base_amplitude: float
    force_amplitude: float
    phase: float


def cycle_of(run: Run) -> Cycle | None:
    """The drive of a run as one sine: as its channel shows it, else as stated; None where it is not one sine
    over at least a cycle."""
    if run.base is not None and run.force is not None:
        return None
    if run.base is not None or run.force is not None:
        found = _sine(run, run.base if run.base is not None else run.force)
        if found is None:
            return None
        frequency, amplitude, phase = found
        based = run.base is not None
        return Cycle(frequency, amplitude if based else 0.0, 0.0 if based else amplitude, phase)
    if run.frequency is None or run.base_amplitude is None:
        return None
    return Cycle(run.frequency, run.base_amplitude, 0.0, run.base_phase)


def outcome_of(run: Run, cycles: int | None = None) -> Outcome | None:
    """Amplitude and stops of a run's last `cycles` cycles, by default of all; None where it has no whole
    cycle."""
    cycle = cycle_of(run)
    if cycle is None or len(run.time) * run.interval * cycle.frequency < 1:
        return None
    return outcome(
        run.displacement,
        interval=run.interval,
        frequency=cycle.frequency,
        natural_frequency=run.rig.natural_frequency,
        cycles=cycles,
    )


def _sine(run: Run, channel: NDArray[np.float64] | None) -> tuple[float, float, float] | None:
    if channel is None or np.ptp(channel) == 0:
        return None
    sine = fit_harmonic(run.time, channel)
    if sine.frequency * len(run.time) * run.interval < 1 or sine.amplitude == 0:
        return None
    if np.std(channel - sine.at(run.time)) > IMPURE * sine.amplitude / math.sqrt(2):
        return None
    return sine.frequency, sine.amplitude, sine.phase
