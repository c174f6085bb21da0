"""The three contacts stepped naively with a very small step: no events, no error control, nothing of `march`.

Velocities live on half steps (leapfrog); friction is decided from one step to the next. Errors are of the
order of one step. Friction against the ground only.
"""

from collections.abc import Callable
from math import exp

import numpy as np

from tests.reference.drive import Drive
from tests.reference.oscillator import Oscillator

Friction = Callable[[float, float, float], float]


def trace(rig: Oscillator, drive: Drive, contact: str, x0: float, v0: float, times: np.ndarray) -> np.ndarray:
    """x [m] at `times` [s], which are equidistant and begin at zero; a step is their spacing."""
    h = float(times[1] - times[0])
    k_d = rig.stiffness if rig.drive_stiffness is None else rig.drive_stiffness
    x, v, z, sliding = x0, v0, 0.0, contact == "paper" and v0 != 0.0
    places = [x]
    for t in times[:-1]:
        t = float(t)
        load = k_d * drive.position(t) + rig.drive_damping * drive.velocity(t) + drive.force(t)
        force = load - rig.stiffness * x - rig.damping * v
        if contact == "rigid":
            free = v + h * force / rig.mass
            size = h / rig.mass * _law(rig, abs(v))
            v = free - size if free > size else free + size if free < -size else 0.0
            x += h * v
        else:
            if contact == "paper" and sliding:
                s = 1.0 if v > 0.0 else -1.0
                friction = -s * _law(rig, abs(v))
            else:
                friction = -rig.k1 * z
                if sliding:
                    friction -= rig.D * v
            before = v
            v += h * (force + friction) / rig.mass
            x += h * v
            z += h * v
            if contact == "paper":
                if sliding and v * before <= 0.0:
                    z, sliding = 0.0, False
                elif not sliding and rig.k1 * abs(z) >= rig.A + rig.C:
                    sliding = True
            else:
                limit = (rig.A * exp(-rig.B * abs(v)) + rig.C) / rig.k1
                sliding = v * z > 0.0 and abs(z) > limit
                if sliding:
                    z = limit if z > 0.0 else -limit
        places.append(x)
    return np.array(places)


def _law(rig: Oscillator, speed: float) -> float:
    return rig.A * exp(-rig.B * speed) + rig.C + rig.D * speed
