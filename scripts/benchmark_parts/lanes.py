"""The task that every solver is given: lanes over frequency and constants, eight natural periods."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tests.reference import loaded, rig1987
from tests.reference.drive import SineDrive
from tests.reference.oscillator import Oscillator

PERIODS = 8
SAMPLES_PER_PERIOD = 16
SAMPLES = PERIODS * SAMPLES_PER_PERIOD + 1
ERROR = 1e-4
"""Difference from the reference that a solver may show, in strokes."""

RATIOS = (0.2, 1.0)
"""Frequency ratios between which the lanes lie: four stops a cycle to none."""


Values = Any
"""One number a lane; inside a vectorised program the number of one lane."""


class Lanes(NamedTuple):
    """Constants of the oscillators, one entry a lane, in SI units; the drive is a sine from phase zero."""

    mass: Values
    stiffness: Values
    drive_stiffness: Values
    damping: Values
    A: Values
    B: Values
    C: Values
    D: Values
    k1: Values
    frequency: Values
    amplitude: Values

    @property
    def size(self) -> int:
        """How many lanes."""
        return len(self.mass)

    @property
    def interval(self) -> np.ndarray:
        """Time between two samples [s], a share of the lane's natural period."""
        return 2 * np.pi * np.sqrt(self.mass / self.stiffness) / SAMPLES_PER_PERIOD

    def take(self, index: np.ndarray) -> Lanes:
        """These lanes alone."""
        return Lanes(*(constant[index] for constant in self))

    def reference(self, lane: int) -> tuple[Oscillator, SineDrive]:
        """Rig and drive of one lane for the event-driven reference."""
        m, stiffness, drive_stiffness, damping, A, B, C, D, k1, frequency, amplitude = (
            float(constant[lane]) for constant in self
        )
        rig = Oscillator(m, stiffness, damping, A, B, C, D, k1, drive_stiffness)
        return rig, SineDrive(frequency, amplitude)

    def times(self, lane: int) -> np.ndarray:
        """The times of the samples [s]."""
        return self.interval[lane] * np.arange(SAMPLES)


def lanes(count: int) -> Lanes:
    """The rig of the 1987 paper at `count` frequency ratios, friction and contact spread by some per cent."""
    rig = rig1987.rig()
    spread = 1 + 0.05 * np.sin(2.4 * np.arange(count))
    each = np.ones(count)
    ratios = np.geomspace(*RATIOS, count)
    return Lanes(
        mass=rig.mass * each,
        stiffness=rig.stiffness * each,
        drive_stiffness=rig.stiffness * each,
        damping=rig.damping * each,
        A=rig.A * spread,
        B=rig.B * each,
        C=rig.C * spread,
        D=rig.D * each,
        k1=rig.k1 / spread,
        frequency=ratios * rig1987.NATURAL_FREQUENCY,
        amplitude=rig1987.BASE_AMPLITUDE * each,
    )


class Checked(NamedTuple):
    """A few lanes with their exact displacement: shape (lanes, samples) [m]."""

    lanes: Lanes
    exact: np.ndarray

    def error(self, displacement: np.ndarray) -> float:
        """The largest difference from the exact displacement over the stroke, root mean square of the
        lanes."""
        largest = np.max(np.abs(np.asarray(displacement) - self.exact), axis=1)
        return float(np.sqrt(np.mean((largest / np.ptp(self.exact, axis=1)) ** 2)))


def checked(count: int) -> Checked:
    """`count` lanes over the whole range, simulated from event to event by the reference."""
    few = lanes(count)
    exact = [loaded.simulate(*few.reference(lane), few.times(lane)).x for lane in range(count)]
    return Checked(few, np.array(exact))
