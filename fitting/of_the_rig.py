"""What a rig has of the same kind as an effect, and how much more or less of it there may be in truth."""

from __future__ import annotations

from fitting.opening import Scales
from jaxstick.record import KnownRig

NEARLY_ALL, MANY = 0.9, 10.0
"""Nearly all of it may be missing, and what has been forgotten may be many times as much."""


def of_the_rig(unit: str, rig: KnownRig, scale: Scales) -> float:
    """What the rig has of a quantity, at the stroke and the speed of the records: something, where it is of
    mass, stiffness or damping."""
    stroke, speed = scale.displacement, scale.speed
    return {
        "kg": rig.mass,
        "N/m": rig.stiffness,
        "N/m^2": rig.stiffness / stroke,
        "N/m^3": rig.stiffness / stroke**2,
        "N s/m": rig.damping,
        "N s^2/m^2": rig.damping / speed,
    }.get(unit, 0.0)


def room(whole: float, otherwise: float) -> tuple[float, float]:
    """By how much a strength may lie below and above none where the rig has so much of its kind: as much as
    it might `otherwise`, at least, which goes by friction and may be small."""
    return max(otherwise, NEARLY_ALL * whole), max(otherwise, MANY * whole)
