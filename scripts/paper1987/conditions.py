"""The conditions of the 1987 paper (Computational Plasticity, Barcelona), in SI units."""

import math
from dataclasses import dataclass

from jaxstick.record import AssumedConstants, KnownRig

MASS = 2.38
STIFFNESS = 1986.0
LOG_DECREMENT = 0.207
STATED_FREQUENCY = 4.6
"""Table 1: m [kg], k [N/m], logarithmic decrement, natural frequency [Hz]."""

B, D = 100.0, 0.002
CONTACT_OVER_SPRING = 50.0
"""Section 4: B [s/m], D [N s/m]; section 2: k1 over the spring's stiffness."""

RATIOS = (0.326, 0.190, 0.109, 0.071, 0.046)
STOPS = (2, 4, 6, 8, 10)
"""Figures 7 and 8: frequency ratios, and the stops a cycle from two to ten."""

BASE_AMPLITUDE = 20.65e-3 / 2
BASE_OVER_STATIC = 3.51
"""Figure 10: amplitude of the base [m] (20.65 mm peak to peak), and y0/x_static."""

DRIVES = ((2.63, 0.376), (3.51, 0.320), (4.90, 0.487))
"""Figure 9: y0/x_static and coefficient of friction of its three curves."""

LOWEST, LARGEST_STROKE = 0.08, 30e-3
"""Section 3: the lowest frequency [Hz]; the exciter's largest stroke, peak to peak [m]."""

GRAVITY = 9.81
FRICTION_RATIO = 0.86
"""Dynamic over static friction, which the paper does not state; see `claims.stops_by_friction_ratio`."""


@dataclass(frozen=True)
class Reading:
    """One way to read the springs of Table 1: total stiffness and what of it joins mass and base [N/m]."""

    words: str
    stiffness: float
    drive_stiffness: float


READINGS = (
    Reading("K = k, all of it drives the mass", STIFFNESS, STIFFNESS),
    Reading("K = k, half of it drives the mass", STIFFNESS, STIFFNESS / 2),
    Reading("K = 2k, k drives the mass (equation 1 as printed)", 2 * STIFFNESS, STIFFNESS),
)
"""The first is used everywhere else: only with it the natural frequency is 4.6 Hz and the stops agree."""


def rig(reading: Reading = READINGS[0]) -> KnownRig:
    """The rig of Table 1; its damping from the logarithmic decrement, c = decrement/pi sqrt(K m)."""
    damping = LOG_DECREMENT / math.pi * math.sqrt(reading.stiffness * MASS)
    return KnownRig(MASS, reading.stiffness, reading.drive_stiffness, damping, 0.0)


def static_friction(mu: float) -> float:
    """A + C [N] for a coefficient of friction."""
    return mu * MASS * GRAVITY


STATIC_FRICTION = static_friction(DRIVES[1][1])
"""A + C [N] of the day of figures 7 to 10's middle curve."""

STATIC_DEFLECTION_SHARE = BASE_AMPLITUDE / BASE_OVER_STATIC * STIFFNESS / STATIC_FRICTION
"""x_static K/(A + C) that makes 20.65 mm and mu = 0.320 a y0/x_static of 3.51: x_static is then not A + C
over K but a dynamic friction of this share of it."""


def base_amplitude(base_over_static: float, mu: float) -> float:
    """y0 [m] of a drive of figure 9, with x_static as for figure 10."""
    return base_over_static * STATIC_DEFLECTION_SHARE * static_friction(mu) / STIFFNESS


def constants(
    static: float = STATIC_FRICTION, ratio: float = FRICTION_RATIO, stiffer: float = 1.0
) -> AssumedConstants:
    """The constants for a static friction [N], dynamic over static friction, and a contact so many times as
    stiff as the paper's."""
    k1 = stiffer * CONTACT_OVER_SPRING * STIFFNESS
    return AssumedConstants(A=(1 - ratio) * static, B=B, C=ratio * static, D=D, k1=k1)
