"""fit.json read back: the constants, the rig and the runs that a comparison needs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from jaxstick.cycle import Cycle
from jaxstick.errors import UserError
from jaxstick.outcome import Outcome
from jaxstick.record import CONSTANTS, AssumedConstants, Effects, KnownRig

FIT_FILE = "fit.json"
SCHEMA = 1

_RIG_KEYS = {
    "mass": "mass_kg",
    "stiffness": "stiffness_n_per_m",
    "drive_stiffness": "drive_stiffness_n_per_m",
    "damping": "damping_n_s_per_m",
    "drive_damping": "drive_damping_n_s_per_m",
    "friction_against": "friction_against",
}


@dataclass(frozen=True)
class SavedRun:
    """What a comparison needs of one run: its drive (None where it is not one sine), rig and assumed
    constants, and what was measured (None where no whole cycle was)."""

    file: str
    cycle: Cycle | None
    rig: KnownRig
    assumed: AssumedConstants
    measured: Outcome | None


@dataclass(frozen=True)
class SavedFit:
    """fit.json: `constants` and `others` hold its entries by name, `effects` are those that the rig file
    stated, `content` everything."""

    path: Path
    constants: Mapping[str, Mapping[str, Any]]
    others: Mapping[str, Mapping[str, Any]]
    rig: KnownRig
    assumed: AssumedConstants
    effects: Effects
    runs: tuple[SavedRun, ...]
    content: Mapping[str, Any]


def rig_entry(rig: KnownRig) -> dict[str, Any]:
    """A rig under the keys of rig.toml."""
    return {_RIG_KEYS[name]: value for name, value in asdict(rig).items()}


def run_entry(run: SavedRun) -> dict[str, Any]:
    """A run as fit.json holds it."""
    cycle = run.cycle
    return {
        "file": run.file,
        "frequency_hz": None if cycle is None else cycle.frequency,
        "base_amplitude_m": None if cycle is None else cycle.base_amplitude,
        "force_amplitude_n": None if cycle is None else cycle.force_amplitude,
        "phase_rad": None if cycle is None else cycle.phase,
        "rig": rig_entry(run.rig),
        "assumed": asdict(run.assumed),
        "measured": None
        if run.measured is None
        else {
            "amplitude_m": run.measured.amplitude,
            "stops": run.measured.stops,
            "stick_fraction": run.measured.stick_fraction,
            "cycles": run.measured.cycles,
        },
    }


def read_fit(path: Path) -> SavedFit:
    """Reads a fit.json, named itself or by its folder.

    Raises UserError where it cannot be read, is no JSON, or does not hold what a fit writes.
    """
    path = Path(path)
    if path.is_dir():
        path = path / FIT_FILE
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise UserError(f"{path}: there is no such file; `jaxstick fit` writes it.") from error
    except OSError as error:
        raise UserError(f"{path}: the file cannot be read ({error.strerror or error}).") from error
    except (ValueError, RecursionError) as error:
        raise UserError(f"{path}: this is not JSON, so no result of jaxstick fit.") from error
    if not isinstance(content, dict) or "constants" not in content:
        raise UserError(f"{path}: this is not a result of jaxstick fit; it holds no constants.")
    if content.get("schema") != SCHEMA:
        raise UserError(
            f"{path}: its schema is {content.get('schema')!r}; this jaxstick reads schema {SCHEMA}."
        )
    try:
        return _saved(path, content)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UserError(
            f"{path}: this is not as jaxstick fit writes it ({type(error).__name__}: {error}); fit again."
        ) from error


def _saved(path: Path, content: dict[str, Any]) -> SavedFit:
    constants = {name: content["constants"][name] for name in CONSTANTS}
    others = dict(content.get("others", {}))
    for entry in (*constants.values(), *others.values()):
        _numbers(entry)
    return SavedFit(
        path=path,
        constants=constants,
        others=others,
        rig=_rig(content["rig"]),
        assumed=AssumedConstants(**{name: entry["assumed"] for name, entry in constants.items()}),
        effects={
            str(key): {str(name): float(value) for name, value in values.items()}
            for key, values in content.get("effects", {}).items()
        },
        runs=tuple(_run(run) for run in content["runs"]),
        content=content,
    )


def _numbers(entry: Mapping[str, Any]) -> None:
    float(entry["value"])
    for name in ("low", "high", "assumed", "standard_error"):
        if entry[name] is not None:
            float(entry[name])


def _rig(entry: Mapping[str, Any]) -> KnownRig:
    values = {name: entry[key] for name, key in _RIG_KEYS.items()}
    against = str(values.pop("friction_against"))
    return KnownRig(**{name: float(value) for name, value in values.items()}, friction_against=against)


def _run(entry: Mapping[str, Any]) -> SavedRun:
    cycle, measured = None, entry["measured"]
    if entry["frequency_hz"] is not None:
        parts = ("frequency_hz", "base_amplitude_m", "force_amplitude_n", "phase_rad")
        cycle = Cycle(*(float(entry[part]) for part in parts))
    return SavedRun(
        file=str(entry["file"]),
        cycle=cycle,
        rig=_rig(entry["rig"]),
        assumed=AssumedConstants(**entry["assumed"]),
        measured=None
        if measured is None
        else Outcome(
            measured["amplitude_m"], measured["stops"], measured["stick_fraction"], measured["cycles"]
        ),
    )
