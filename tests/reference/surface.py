"""The surface the mass rubs on: the standing guide, or the moving base."""

from dataclasses import dataclass

from tests.reference.drive import Drive, OfTime
from tests.reference.oscillator import Oscillator


def _still(_: float) -> float:
    return 0.0


@dataclass(frozen=True)
class Surface:
    """The surface's motion; the mass slides at q = x - position with w = v - velocity."""

    position: OfTime
    velocity: OfTime
    acceleration: OfTime


def surface_of(rig: Oscillator, drive: Drive) -> Surface:
    """The surface that `rig.friction_against` names."""
    if rig.friction_against == "ground":
        return Surface(_still, _still, _still)
    return Surface(drive.position, drive.velocity, drive.acceleration)
