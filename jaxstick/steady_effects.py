"""What effects mean for periodic states: which rule them out, and which a periodic state does not show."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.nominal import nominal
from jaxstick.oscillator import Oscillator
from jaxstick.parts.drive import SineDrive
from jaxstick.precision import float64
from jaxstick.record import AssumedConstants, KnownRig

SOME_RIG = KnownRig(mass=1.0, stiffness=1.0, drive_stiffness=1.0, damping=0.1, drive_damping=0.0)
SOME_CONSTANTS = AssumedConstants(A=0.5, B=1.0, C=1.0, D=0.1, k1=10.0)
MOVING = ("rig", "drive", "friction", "contact")
"""The parts that a motion depends on."""
TIMES = (0.0, 7.0)
"""Two instants [s], the drive's phase taken to be the same at both."""


@float64
def steady_notices(effects: Mapping[str, AbstractEffect], where: object) -> list[str]:
    """Sentences on the effects that concern the record of a motion and not the motion itself.

    Raises UserError, beginning with `where`, the file's name, for an effect whose forces follow the run's own
    time instead of the drive's phase: no state comes back after a period of the drive then.
    """
    plain = nominal(SOME_RIG, SOME_CONSTANTS, SineDrive(1.0, 1.0))
    notices = []
    for key, effect in effects.items():
        oscillator = effect.attach(plain)
        early, late = (_forces(oscillator, t) for t in TIMES)
        if not np.array_equal(early, late):
            raise UserError(
                f"{where}: [effects.{key}] changes in the course of a run, so there is no periodic state to "
                "sweep; take it out of the file."
            )
        if all(getattr(oscillator, part) is getattr(plain, part) for part in MOVING):
            notices.append(
                f"{where}: [effects.{key}] concerns what is recorded; a sweep shows the motion itself, which "
                "is the same without it."
            )
    return notices


def _forces(oscillator: Oscillator, t: float) -> np.ndarray:
    """Forces on the mass in one state of motion and phase of the drive, at a time of the run's own."""
    motion = oscillator.motion(t, oscillator.drive.at(0.2), 0.3, 0.4, 0.0)
    law, rig = oscillator.friction.initial(motion), oscillator.rig.initial(motion)
    forces = (
        oscillator.friction.limit(law, motion),
        oscillator.friction.viscous(law, motion),
        oscillator.rig.force(rig, motion),
    )
    return np.asarray([float(force) for force in forces])
