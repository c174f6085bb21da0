"""The rig of the 1987 paper in numbers: Table 1, figures 7 and 8."""

from math import pi, sqrt

from tests.reference.drive import SineDrive
from tests.reference.oscillator import Oscillator

MASS = 2.38
STIFFNESS = 1986.0
LOG_DECREMENT = 0.207
BASE_AMPLITUDE = 10.325e-3
STATIC_FRICTION = 7.47
NATURAL_FREQUENCY = sqrt(STIFFNESS / MASS) / (2.0 * pi)
DAMPING = LOG_DECREMENT / pi * sqrt(STIFFNESS * MASS)
"""c = 2 m omega_n zeta [N s/m] with zeta = log. decrement/(2 pi)."""

STOPS = {0.326: 2, 0.190: 4, 0.109: 6, 0.071: 8, 0.046: 10}
"""Stops per cycle by frequency ratio."""


def rig(dynamic_ratio: float = 0.86, k1: float = 50.0 * STIFFNESS) -> Oscillator:
    """The oscillator with C/(A + C) = `dynamic_ratio` and a contact of stiffness k1 [N/m]."""
    C = dynamic_ratio * STATIC_FRICTION
    return Oscillator(MASS, STIFFNESS, DAMPING, STATIC_FRICTION - C, 100.0, C, 0.002, k1)


def drive(frequency_ratio: float) -> SineDrive:
    """The vibrating table at `frequency_ratio` times the natural frequency."""
    return SineDrive(frequency_ratio * NATURAL_FREQUENCY, BASE_AMPLITUDE)
