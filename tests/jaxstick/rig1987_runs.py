"""The rig of 1987 under jaxstick: its five runs simulated once, for tests of what a motion amounts to."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from jaxstick.nominal import nominal
from jaxstick.oscillator import Start
from jaxstick.parts.drive import SineDrive
from jaxstick.record import AssumedConstants, KnownRig
from jaxstick.side_by_side import Journey, side_by_side

RIG = KnownRig(2.38, 1986.0, 1986.0, 4.53, 0.0)
STOPS = {0.326: 2, 0.190: 4, 0.109: 6, 0.071: 8, 0.046: 10}
RATE = 500.0
CYCLES = 12


class Motion(NamedTuple):
    """A motion from rest over 12 cycles: displacement [m], interval [s], the drive's frequency [Hz]."""

    displacement: np.ndarray
    interval: float
    frequency: float


def constants(dynamic_ratio: float, k1: float = 99300.0) -> AssumedConstants:
    """7.47 N of static friction, of which the given share remains in fast slip."""
    return AssumedConstants(7.47 * (1 - dynamic_ratio), 100.0, 7.47 * dynamic_ratio, 0.002, k1)


@functools.cache
def motions(dynamic_ratio: float) -> dict[float, Motion]:
    """The motion of every run by its frequency ratio."""
    frequencies = {ratio: ratio * RIG.natural_frequency for ratio in STOPS}
    journeys = [
        Journey(
            nominal(RIG, constants(dynamic_ratio), SineDrive(frequency, 10.325e-3)),
            Start(),
            0.0,
            1 / RATE,
            round(CYCLES * RATE / frequency),
        )
        for frequency in frequencies.values()
    ]
    return {
        ratio: Motion(np.asarray(trajectory.displacement), 1 / RATE, frequency)
        for (ratio, frequency), trajectory in zip(
            frequencies.items(), side_by_side(journeys, resolution=64.0), strict=True
        )
    }
