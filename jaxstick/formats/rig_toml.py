"""rig.toml as SI numbers: keys with unit suffixes, types, signs; nothing about the records themselves."""

import hashlib
import math
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from jaxstick.errors import UserError
from jaxstick.formats.files import opened
from jaxstick.formats.units import (
    ANGLE,
    DAMPING,
    FORCE,
    FREQUENCY,
    INVERSE_VELOCITY,
    LENGTH,
    MASS,
    PURE,
    STIFFNESS,
    TIME,
    VELOCITY,
    Units,
    spelled,
    spellings,
    take_apart,
)
from jaxstick.formats.words import did_you_mean, listed, shown

MAX_BYTES = 1_000_000

LARGEST = 1e30
"""Numbers must be smaller, so that their products stay finite."""

SURFACES = ("ground", "base")
SECTIONS = ("rig", "assumed", "noise", "effects", "run")

RIG: Mapping[str, Units] = {
    "mass": MASS,
    "stiffness": STIFFNESS,
    "drive_stiffness": STIFFNESS,
    "log_decrement": PURE,
    "damping_ratio": PURE,
    "damping": DAMPING,
    "drive_damping": DAMPING,
}
ASSUMED: Mapping[str, Units] = {
    "A": FORCE,
    "B": INVERSE_VELOCITY,
    "C": FORCE,
    "D": DAMPING,
    "k1": STIFFNESS,
}
NOISE: Mapping[str, Units] = {
    "displacement": LENGTH,
    "friction": FORCE,
    "base": LENGTH,
    "force": FORCE,
    "velocity": VELOCITY,
}
RUN: Mapping[str, Units] = {
    "frequency": FREQUENCY,
    "base_amplitude": LENGTH,
    "base_phase": ANGLE,
    "duration": TIME,
    "cycles": PURE,
    "sample_rate": FREQUENCY,
}
DAMPINGS = ("log_decrement", "damping_ratio", "damping")
"""Three ways to give the total damping; at most one of them."""

MAY_BE_ZERO = frozenset({"stiffness", "drive_stiffness", *DAMPINGS, "drive_damping", "A", "B", "C", "D"})
MAY_BE_NEGATIVE = frozenset({"base_phase"})


@dataclass(frozen=True)
class RunTable:
    """One [[run]] as written: SI values by name, what it overrides, and where it stands."""

    file: str
    values: Mapping[str, float]
    hold_out: bool
    rig: Mapping[str, Any]
    assumed: Mapping[str, float]
    where: str


@dataclass(frozen=True)
class RigTables:
    """rig.toml as written, every number in SI.

    rig: the keys of RIG without their units that are given, and friction_against; of DAMPINGS at most one.
    effects: parameters by name under each effect's key, in the order of the file; whether there are such
    effects and parameters is not looked at here.
    """

    path: Path
    name: str | None
    rig: Mapping[str, Any]
    assumed: Mapping[str, float]
    noise: Mapping[str, float]
    runs: tuple[RunTable, ...]
    effects: Mapping[str, Mapping[str, float]]
    sha256: str


def read_rig_toml(path: Path) -> RigTables:
    """Reads rig.toml.

    Raises:
        UserError: for a file that cannot be read or is no TOML, for unknown keys and units, wrong types,
            numbers out of range, a quantity given twice, and two runs of one file.
    """
    with opened(path, MAX_BYTES) as stream:
        data = stream.read()
    try:
        text = data.decode("utf-8-sig")
        tables = tomllib.loads(text)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise UserError(
            f"{path}, line {line}: the byte 0x{data[error.start]:02x} is not UTF-8 text."
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{path}: this is not TOML: {_first_lower(str(error))}.") from error
    except RecursionError as error:
        raise UserError(f"{path}: this is not TOML: its values are nested too deeply.") from error

    reader = _Reader(path, text)
    top = reader.section(tables, "", {}, {"name": reader.text} | dict.fromkeys(SECTIONS))
    return RigTables(
        path,
        top.get("name"),
        reader.rig(reader.table(tables, "rig", required=True), "rig"),
        reader.section(reader.table(tables, "assumed"), "assumed", ASSUMED),
        reader.section(reader.table(tables, "noise"), "noise", NOISE),
        reader.runs(tables.get("run", [])),
        reader.effects(reader.table(tables, "effects")),
        hashlib.sha256(data).hexdigest(),
    )


@dataclass
class _Reader:
    """Checks tables against their quantities; `run` counts the [[run]] tables, for messages."""

    path: Path
    source: str
    run: int = field(default=-1)

    def where(self, section: str, key: str) -> str:
        line = _key_line(self.source, section, self.run, key)
        place = f"{self.path}, line {line}: " if line else f"{self.path}: "
        return place + (f"[{section}] {key}" if section else key)

    def table(self, tables: Mapping[str, Any], name: str, required: bool = False) -> Mapping[str, Any]:
        if required and name not in tables:
            raise UserError(
                f"{self.path}: there is no [{name}] section; it holds mass_kg and stiffness_n_per_m."
            )
        table = tables.get(name, {})
        if not isinstance(table, dict):
            raise UserError(f"{self.where('', name)} is {_kind(table)}; expected is a section [{name}].")
        return table

    def section(
        self,
        table: Mapping[str, Any],
        section: str,
        quantities: Mapping[str, Units],
        others: Mapping[str, Callable[[str, str, Any], Any] | None] | None = None,
    ) -> dict[str, Any]:
        """The table's values in SI; `others` reads the keys that hold no number (None: read elsewhere)."""
        others = others or {}
        values: dict[str, Any] = {}
        spelt: dict[str, str] = {}
        for key, value in table.items():
            if key in others:
                read = others[key]
                if read is not None:
                    values[key] = read(section, key, value)
                continue
            quantity, factor = self._quantity(section, key, quantities, others)
            if quantity in values:
                raise UserError(
                    f"{self.where(section, key)} and {spelt[quantity]} give the same quantity; keep one."
                )
            values[quantity] = self.number(section, key, value, quantity) * factor
            spelt[quantity] = key
        return values

    def rig(self, table: Mapping[str, Any], section: str) -> dict[str, Any]:
        values = self.section(table, section, RIG, {"friction_against": self.surface})
        given = [name for name in DAMPINGS if name in values]
        if len(given) > 1:
            raise UserError(
                f"{self.path}: [{section}] gives both {given[0]} and {given[1]}; keep one of them."
            )
        return values

    def effects(self, table: Mapping[str, Any]) -> dict[str, dict[str, float]]:
        """The parameters of each effect, in SI as they stand."""
        found = {}
        for key, values in table.items():
            if not isinstance(values, dict):
                raise UserError(
                    f"{self.where('effects', key)} is {_kind(values)}; expected is a section [effects.{key}] "
                    "with the effect's parameters."
                )
            section = f"effects.{key}"
            found[key] = {name: self.finite(section, name, value) for name, value in values.items()}
        return found

    def runs(self, tables: Any) -> tuple[RunTable, ...]:
        if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
            raise UserError(
                f"{self.where('', 'run')} is not a list of runs; begin each run with a line [[run]]."
            )
        runs: list[RunTable] = []
        lines: dict[PurePosixPath, str] = {}
        for self.run, table in enumerate(tables):
            run = self._run(table, f"run-{self.run + 1:02d}.csv")
            name = PurePosixPath(run.file)
            if name in lines:
                raise UserError(f"{run.where} names the file {shown(run.file)} that another run has already.")
            lines[name] = run.where
            runs.append(run)
        return tuple(runs)

    def _run(self, table: Mapping[str, Any], default_file: str) -> RunTable:
        tables = {"rig": None, "assumed": None}
        values = self.section(table, "run", RUN, {"file": self.file_name, "hold_out": self.switch, **tables})
        if "duration" in values and "cycles" in values:
            raise UserError(f"{self.where('run', 'cycles')} and the duration both give the length; keep one.")
        overrides = {name: table.get(name, {}) for name in tables}
        for name, override in overrides.items():
            if not isinstance(override, dict):
                raise UserError(
                    f"{self.where('run', name)} is {_kind(override)}; a table like {{ C_n = 3.1 }} is "
                    "expected."
                )
        return RunTable(
            values.pop("file", default_file),
            values,
            values.pop("hold_out", False),
            self.rig(overrides["rig"], "run.rig"),
            self.section(overrides["assumed"], "run.assumed", ASSUMED),
            self.where("run", "file" if "file" in table else next(iter(table), "file")),
        )

    def _quantity(
        self, section: str, key: str, quantities: Mapping[str, Units], others: Mapping[str, object]
    ) -> tuple[str, float]:
        named = take_apart(key, quantities)
        known = [*spellings(quantities), *others]
        if named is None:
            raise UserError(f"{self.where(section, key)} is not a known key{did_you_mean(key, known)}.")
        if named.factor is not None:
            return named.quantity, named.factor
        allowed = listed(spelled(named.quantity, unit) for unit in quantities[named.quantity])
        if not named.unit:
            raise UserError(f"{self.where(section, key)} does not say its unit; write {allowed}.")
        near = did_you_mean(key, [name for name in known if name not in allowed])
        raise UserError(f"{self.where(section, key)} has an unknown unit; expected is {allowed}{near}.")

    def number(self, section: str, key: str, value: Any, quantity: str) -> float:
        number = self.finite(section, key, value)
        if number < 0 and quantity not in MAY_BE_NEGATIVE:
            raise UserError(f"{self.where(section, key)} is {number:g}; it must not be negative.")
        if number == 0 and quantity not in MAY_BE_ZERO | MAY_BE_NEGATIVE:
            raise UserError(f"{self.where(section, key)} is 0; it must be greater than 0.")
        return number

    def finite(self, section: str, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UserError(f"{self.where(section, key)} is {_kind(value)}; expected is a number.")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not abs(number) < LARGEST:
            raise UserError(f"{self.where(section, key)} is {shown(value)}; expected is a finite number.")
        return number

    def text(self, section: str, key: str, value: Any) -> str:
        if not isinstance(value, str) or not value.strip():
            raise UserError(f"{self.where(section, key)} is {_kind(value)}; expected is a text.")
        return value

    def switch(self, section: str, key: str, value: Any) -> bool:
        if not isinstance(value, bool):
            raise UserError(f"{self.where(section, key)} is {_kind(value)}; expected is true or false.")
        return value

    def surface(self, section: str, key: str, value: Any) -> str:
        if value not in SURFACES:
            raise UserError(f'{self.where(section, key)} is {shown(value)}; expected is "ground" or "base".')
        return value

    def file_name(self, section: str, key: str, value: Any) -> str:
        name = self.text(section, key, value)
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts or not path.parts or "\\" in name or "\0" in name:
            raise UserError(
                f"{self.where(section, key)} is {shown(name)}; expected is the name of a file in the data "
                "set's folder."
            )
        return name


def _kind(value: Any) -> str:
    """What a TOML value is, for a message."""
    if isinstance(value, str):
        return f"the text {shown(value)}" if value.strip() else "an empty text"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"the number {value:g}"
    if isinstance(value, list):
        return "a list"
    return "a table" if isinstance(value, dict) else "a date or time"


def _first_lower(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:].rstrip(".")


def _key_line(source: str, section: str, run: int, key: str) -> int | None:
    """The line on which a key stands, or None where it is written in a way this simple search does not see.

    section: 'rig', 'run', 'run.rig' ... or '' for the top; `run` counts the [[run]] tables from 0.
    """
    inner = section.removeprefix("run.") if section.startswith("run.") else None
    current, count = "", -1
    for number, line in enumerate(source.splitlines(), start=1):
        header = re.match(r"\s*(\[\[?)\s*([\w.\s]+?)\s*\]", line)
        if header:
            current = re.sub(r"\s", "", header[2])
            count += header[1] == "[[" and current == "run"
            if not section and current == key:
                return number
        in_place = current == section and (not section.startswith("run") or count == run)
        if in_place and re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*=", line):
            return number
        if (
            inner
            and current == "run"
            and count == run
            and re.match(rf"\s*{inner}\s*=.*\b{re.escape(key)}\b", line)
        ):
            return number
    return None
