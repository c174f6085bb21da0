"""Does a record agree with what rig.toml says of it? A unit written wrongly is the mistake to catch."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxstick.errors import UserError
from jaxstick.formats.channels import Channels
from jaxstick.formats.harmonic import fit_harmonic
from jaxstick.formats.units import CHANNELS, likely_unit, spelled

AMPLITUDE_FACTOR = 5.0
"""A recorded base amplitude may differ from the stated one by this factor."""

MOTION_FACTOR = 300.0
"""The mass may move this many times as far as the drive would push it at rest; resonance allows some tens."""

FRICTION_FACTOR = 100.0
"""The friction force may exceed the spring and drive forces by this factor."""

VELOCITY_FACTOR = 10.0
"""The recorded velocity may differ from the displacement's change by this factor."""

FREQUENCY_FACTOR = 2.0
FREQUENCY_NOTICE = 0.02
STILL = 1e-4
SIGN_CORRELATION = 0.3
FEWEST_PER_CYCLE = 4.0
SHORTEST_IN_CYCLES = 0.25


@dataclass(frozen=True)
class Stated:
    """What is said of one run, in SI units; None where nothing is said."""

    stiffness: float
    drive_stiffness: float
    friction_against: str
    frequency: float | None
    base_amplitude: float | None


def check_record(record: Channels, stated: Stated) -> list[str]:
    """Notices on what is odd in a record.

    Raises:
        UserError: for what cannot be: the sentence guesses the unit that was meant.
    """
    notices = [
        *_check_cycles(record, stated),
        *_check_base(record, stated),
        *_check_motion(record, stated),
    ]
    _check_velocity(record)
    _check_friction(record, stated)
    return notices


def amplitude(samples: NDArray[np.float64]) -> float:
    """Half the range of the samples."""
    return float(np.ptp(samples)) / 2


def _column(record: Channels, quantity: str) -> str:
    return f"{record.path}, column {spelled(quantity, record.units[quantity])}"


def _meant(record: Channels, quantity: str, size: float, expected: float, within: float) -> str:
    """'; is it in mm (base_mm)?' where another unit would agree, else nothing."""
    unit = likely_unit(size, record.units[quantity], expected, CHANNELS[quantity], within)
    return f"; is it in {unit} ({spelled(quantity, unit)})?" if unit else "."


def _check_cycles(record: Channels, stated: Stated) -> list[str]:
    if stated.frequency is None:
        return []
    cycles = stated.frequency * record.interval * len(record.time)
    per_cycle = 1 / (stated.frequency * record.interval)
    where = f"{_column(record, 'time')}: at {stated.frequency:g} Hz"
    if per_cycle < FEWEST_PER_CYCLE:
        raise UserError(
            f"{where} this makes {per_cycle:.3g} samples a cycle, and at least {FEWEST_PER_CYCLE:g} are "
            "needed; is the unit of time or the frequency wrong?"
        )
    if cycles < SHORTEST_IN_CYCLES:
        raise UserError(
            f"{where} the record lasts {cycles:.3g} cycles, and at least {SHORTEST_IN_CYCLES:g} are needed; "
            "is the unit of time or the frequency wrong?"
        )
    if cycles < 1:
        return [f"{record.path}: the record is shorter than one cycle of the drive ({cycles:.2f})."]
    return []


def _check_base(record: Channels, stated: Stated) -> list[str]:
    base = record.values.get("base")
    if base is None:
        return []
    where, found = _column(record, "base"), amplitude(base)
    expected = stated.base_amplitude
    whole = stated.frequency is None or stated.frequency * record.interval * len(base) >= 1
    if expected is not None:
        ratio = found / expected
        if ratio > AMPLITUDE_FACTOR or (whole and ratio < 1 / AMPLITUDE_FACTOR):
            raise UserError(
                f"{where}: the amplitude is {found:.4g} m where rig.toml says {expected:.4g} m"
                + _meant(record, "base", found, expected, AMPLITUDE_FACTOR)
            )
    if stated.frequency is None or stated.frequency * record.interval * len(base) < 2:
        return []
    frequency = fit_harmonic(record.time, base).frequency
    ratio = frequency / stated.frequency
    if not 1 / FREQUENCY_FACTOR < ratio < FREQUENCY_FACTOR:
        raise UserError(
            f"{where}: the base moves at {frequency:.4g} Hz where rig.toml says {stated.frequency:.4g} Hz; "
            "is the unit of time or the frequency wrong?"
        )
    if abs(ratio - 1) > FREQUENCY_NOTICE:
        return [
            f"{where}: the base moves at {frequency:.4g} Hz where rig.toml says {stated.frequency:.4g} Hz."
        ]
    return []


def _check_motion(record: Channels, stated: Stated) -> list[str]:
    """Compares the mass's travel with the travel at which the spring balances the drive."""
    push = _drive_force(record, stated)
    if stated.stiffness == 0 or push == 0:
        return []
    still, found = push / stated.stiffness, amplitude(record.values["displacement"])
    where = _column(record, "displacement")
    if found > MOTION_FACTOR * still:
        raise UserError(
            f"{where}: the mass moves by {found:.4g} m where the drive would push it by {still:.4g} m"
            + _meant(record, "displacement", found, still, MOTION_FACTOR / 10)
        )
    if found < STILL * still:
        return [
            f"{where}: the mass moves by only {found:.4g} m where the drive would push it by {still:.4g} m; "
            "it may be stuck throughout, or the unit may be wrong."
        ]
    return []


def _drive_force(record: Channels, stated: Stated) -> float:
    """Amplitude of k_d y + u [N]."""
    base = amplitude(record.values["base"]) if "base" in record.values else stated.base_amplitude or 0.0
    force = amplitude(record.values["force"]) if "force" in record.values else 0.0
    return stated.drive_stiffness * base + force


def _check_velocity(record: Channels) -> None:
    velocity = record.values.get("velocity")
    if velocity is None:
        return
    travelled = np.cumsum(velocity) * record.interval
    expected, found = _detrended_size(record.values["displacement"]), _detrended_size(travelled)
    if not 1 / VELOCITY_FACTOR < found / expected < VELOCITY_FACTOR:
        raise UserError(
            f"{_column(record, 'velocity')}: the velocity adds up to a travel of {found:.4g} m where the "
            "displacement "
            f"has {expected:.4g} m" + _meant(record, "velocity", found, expected, VELOCITY_FACTOR)
        )


def _detrended_size(samples: NDArray[np.float64]) -> float:
    """Standard deviation about the best straight line."""
    index = np.linspace(-1, 1, len(samples))
    level = samples - samples.mean()
    return float(np.std(level - index * np.dot(index, level) / np.dot(index, index)))


def _check_friction(record: Channels, stated: Stated) -> None:
    friction = record.values.get("friction")
    if friction is None:
        return
    where = _column(record, "friction")
    found = amplitude(friction)
    others = _drive_force(record, stated) + stated.stiffness * amplitude(record.values["displacement"])
    if others > 0 and found > FRICTION_FACTOR * others:
        raise UserError(
            f"{where}: the friction reaches {found:.4g} N where spring and drive reach {others:.4g} N"
            + _meant(record, "friction", found, others, FRICTION_FACTOR / 2)
        )
    sliding = _sliding_velocity(record, stated)
    if sliding is None:
        return
    centred = friction - friction.mean()
    alignment = float(np.dot(centred, sliding) / np.sqrt(np.dot(centred, centred) * np.dot(sliding, sliding)))
    if alignment > max(SIGN_CORRELATION, 4 / np.sqrt(len(sliding))):
        raise UserError(
            f"{where}: the friction pushes along with the motion (correlation with the velocity "
            f"{alignment:.2f}); it is the force on the mass and opposes its motion, so the sign of the "
            "column is to be turned."
        )


def _sliding_velocity(record: Channels, stated: Stated) -> NDArray[np.float64] | None:
    """Velocity of the mass against the surface that rubs, or None where that surface's motion is not
    recorded."""
    slip = record.values["displacement"]
    if stated.friction_against == "base":
        if "base" not in record.values:
            return None
        slip = slip - record.values["base"]
    velocity = np.gradient(slip, record.interval)
    return velocity if np.any(velocity) else None
