"""How long a cycle of a run's excitation is, be it a pure sine or nearly one."""

from __future__ import annotations

import numpy as np

from jaxstick.formats.harmonic import fit_harmonic
from jaxstick.record import Run

IMPURE = 0.02
"""An excitation of which one sine leaves no more than this share of the variance repeats itself."""
SHORTEST = 2 / 3
"""A record shows no cycle of which it holds less than this share: a ramp is a part of a sine as well."""


def frequency_of(run: Run) -> float | None:
    """The frequency of a run's excitation [Hz]; None where none is stated or seen."""
    if run.frequency is not None:
        return run.frequency
    for channel in (run.base, run.force):
        if channel is not None and np.ptp(channel) > 0:
            found = fit_harmonic(run.time, channel)
            left = np.var(channel - found.at(run.time))
            cycles = found.frequency * run.interval * len(channel)
            if cycles >= SHORTEST and left < IMPURE * np.var(channel):
                return found.frequency
    return None


def samples_a_cycle(run: Run) -> float | None:
    """The number of samples in a cycle of a run's excitation; None where none is stated or seen."""
    frequency = frequency_of(run)
    return None if frequency is None else 1 / (frequency * run.interval)


def whole_cycles(run: Run) -> int:
    """The number of samples from a run's beginning on in whole cycles of its excitation: all of them where
    there is no cycle, or none is whole.

    A cycle that is cut short, by more than half a sample, would count one side of it more than the other.
    """
    samples, cycle = len(run.time), samples_a_cycle(run)
    if cycle is None or cycle > samples:
        return samples
    return min(round((samples + 0.5) // cycle * cycle), samples)
