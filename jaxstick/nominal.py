"""From what is known and assumed of a rig to the nominal oscillator."""

from __future__ import annotations

from pathlib import Path

from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.hypothesis import effects_as_stated
from jaxstick.oscillator import Oscillator
from jaxstick.parts.contact import LoadedContact
from jaxstick.parts.drive import AbstractDrive
from jaxstick.parts.friction import ExponentialFriction
from jaxstick.parts.guide import BaseGuide, GroundGuide
from jaxstick.parts.rig import Rig
from jaxstick.record import RIG_FILE, AssumedConstants, DataSet, KnownRig, RigSheet

_GUIDES = {"ground": GroundGuide, "base": BaseGuide}


def rig_of(known: KnownRig) -> Rig:
    """The rig with the values that are known of it."""
    return Rig(
        mass=known.mass,
        stiffness=known.stiffness,
        drive_stiffness=known.drive_stiffness,
        damping=known.damping,
        drive_damping=known.drive_damping,
        guide=_GUIDES[known.friction_against](),
    )


def nominal(rig: KnownRig, constants: AssumedConstants, drive: AbstractDrive) -> Oscillator:
    """The oscillator with the loaded contact and these constants; A, B and D default to none of their effect.

    Raises UserError where C or k1, without which there is no friction to simulate, is not given.
    """
    missing = [name for name in ("C", "k1") if getattr(constants, name) is None]
    if missing:
        raise UserError(f"[assumed] does not give {' and '.join(missing)}, which a simulation needs.")
    law = ExponentialFriction(
        A=constants.A or 0.0, B=constants.B or 0.0, C=constants.C or 0.0, D=constants.D or 0.0
    )
    return Oscillator(rig_of(rig), drive, law, LoadedContact(constants.k1 or 0.0))


def effects_of(source: DataSet | RigSheet) -> dict[str, AbstractEffect]:
    """The effects that a data set or a rig file states, with the values given there.

    Raises UserError naming the file; see `effects_as_stated`.
    """
    path = source.path if isinstance(source, RigSheet) else source.rig_file
    return effects_as_stated(source.effects, path or Path(RIG_FILE))
