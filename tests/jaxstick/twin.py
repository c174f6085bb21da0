"""Our oscillator for a reference rig and drive: the same numbers, no shared code."""

from __future__ import annotations

import numpy as np

from jaxstick.oscillator import Oscillator
from jaxstick.parts.contact import AbstractContact, LoadedContact
from jaxstick.parts.drive import SineDrive
from jaxstick.parts.friction import ExponentialFriction
from jaxstick.parts.guide import BaseGuide, GroundGuide
from jaxstick.parts.rig import Rig
from jaxstick.simulate import Trajectory, simulate
from tests.reference.drive import SineDrive as ReferenceDrive
from tests.reference.oscillator import Oscillator as ReferenceRig


def twin(
    rig: ReferenceRig, drive: ReferenceDrive, contact: type[AbstractContact] = LoadedContact
) -> Oscillator:
    """The oscillator with the constants of the reference; base and force must share their phase."""
    assert drive.base_phase == drive.force_phase or not (drive.base_amplitude and drive.force_amplitude)
    phase = drive.base_phase if drive.base_amplitude else drive.force_phase
    return Oscillator(
        Rig(
            rig.mass,
            rig.stiffness,
            rig.stiffness if rig.drive_stiffness is None else rig.drive_stiffness,
            rig.damping,
            rig.drive_damping,
            BaseGuide() if rig.friction_against == "base" else GroundGuide(),
        ),
        SineDrive(drive.frequency, drive.base_amplitude, drive.force_amplitude, phase),
        ExponentialFriction(rig.A, rig.B, rig.C, rig.D),
        contact(rig.k1),  # pyright: ignore[reportCallIssue]
    )


def simulate_twin(
    rig: ReferenceRig,
    drive: ReferenceDrive,
    times: np.ndarray,
    steps: int,
    contact: type[AbstractContact] = LoadedContact,
) -> Trajectory:
    """Our simulation from rest at the (uniform) times, with `steps` integration steps between two."""
    interval = float(times[1] - times[0])
    trajectory = simulate(
        twin(rig, drive, contact), samples=len(times), interval=interval, steps_per_sample=steps
    )
    return Trajectory(*(np.asarray(channel) for channel in trajectory))  # pyright: ignore[reportArgumentType]
