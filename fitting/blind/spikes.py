"""Tier D: a known fault of the measuring chain put on records of a real rig."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from fitting.blind.case import Settings
from fitting.blind.folder import Column, write_table
from fitting.blind.formulation import Floats, Formulation, RunFacts, Shape, Signals, between
from fitting.blind.menu import FAMILIES, aliases, formulation
from fitting.blind.scales import Scales
from fitting.blind.seeds import stream
from fitting.blind.strength import TIMES
from jaxstick.errors import UserError

SPIKES = (
    ("force_delay", "A"),
    ("force_lowpass", "A"),
    ("force_gain", "A"),
    ("force_offset", "A"),
    ("force_drift", "A"),
    ("force_position_crosstalk", "A"),
    ("force_hysteresis", "A"),
    ("displacement_delay", "A"),
    ("displacement_delay", "B"),
    ("displacement_gain", "A"),
)
"""Faults and formulations; the B of a delay is a low-pass."""

UNITS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "base": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "displacement": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "friction": {"n": 1.0, "kn": 1e3},
}
ROUNDS = 4
DIGITS = 9


@dataclass(frozen=True)
class Table:
    """A CSV file as it is: names of the columns, their cells as numbers, decimals of each."""

    names: tuple[str, ...]
    numbers: Floats
    decimals: tuple[int, ...]

    def place(self, quantity: str) -> tuple[int, float] | None:
        """Which column holds a quantity, and the factor to SI; None where there is none."""
        for index, name in enumerate(self.names):
            for unit, factor in UNITS[quantity].items():
                if name.lower() == f"{quantity}_{unit}":
                    return index, factor
        return None

    def signal(self, quantity: str) -> Floats | None:
        """The samples of a quantity [SI]."""
        found = self.place(quantity)
        return None if found is None else self.numbers[:, found[0]] * found[1]


@dataclass(frozen=True)
class Source:
    """A data set on which spikes are put: its rig.toml as a dictionary, its tables by file name."""

    name: str
    rig: dict[str, Any]
    tables: dict[str, Table]


def read_source(folder: Path) -> Source:
    """Reads a data set as it is; raises UserError where it is none of comma-separated numbers."""
    try:
        rig = tomllib.loads((folder / "rig.toml").read_text(encoding="utf-8"))
        files = [run["file"] for run in rig["run"]]
        return Source(folder.name, rig, {file: _read_table(folder / file) for file in files})
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise UserError(
            f"{folder}: no fault can be put on it; expected are rig.toml and CSV files with commas."
        ) from error


def _read_table(path: Path) -> Table:
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
    header, *rows = [line for line in lines if not line.startswith("#")]
    cells = [row.split(",") for row in rows]
    decimals = [
        max(len(cell.partition(".")[2].split("e")[0]) for cell in column)
        for column in zip(*cells, strict=True)
    ]
    names = tuple(name.strip() for name in header.split(","))
    return Table(names, np.array(cells, dtype=float), tuple(min(number, DIGITS) for number in decimals))


def spikes_on(source: Source) -> tuple[tuple[str, str], ...]:
    """The faults, with their formulations, of those channels that every file of a data set holds."""
    silent = any(table.place("friction") is None for table in source.tables.values())
    return tuple(spike for spike in SPIKES if not (silent and spike[0].startswith("force_")))


def spiked_case(
    settings: Settings, number: int, source: Source, spike: tuple[str, str] | None, folder: Path
) -> dict[str, Any]:
    """Writes the data set with the spike on it (None: as it is) and returns the answer.

    Every case on this source has files of the same form; a spiked channel is rounded as the record was. The
    spike's size is such that what it changes is 3 to 30 times the channel's noise (1/2 to 8 in weak sets), or
    as the settings have it: records whose own effects open a larger gap show no smaller fault.
    """
    random = stream(settings.family, settings.seed, "spike", number)
    signals = [_signals(table) for table in source.tables.values()]
    answer = {
        "kind": "none" if spike is None else "single",
        "tier": "D",
        "truth": ["none"] if spike is None else [spike[0]],
        "families": [] if spike is None else [FAMILIES[spike[0]]],
        "aliases": {} if spike is None else {spike[0]: list(aliases(spike[0]))},
        "unlisted": [],
        "strength": settings.strength,
        "effects": {},
        "gap_ratio": 0.0,
        "constants": {},
        "rig": {},
        "source": source.name,
    }
    changed = signals
    if spike is not None:
        effect = formulation(*spike)
        scales = _scales(source, signals)
        shape = effect.shape(scales, random)
        wanted = between(random, *(settings.spike_times or TIMES[settings.strength]))
        sign = -1.0 if effect.signed and random.random() < 0.5 else 1.0
        strength = effect.typical(scales)
        opened = 0.0
        for _ in range(ROUNDS):
            changed = [_with(effect, one, sign * strength, shape, index) for index, one in enumerate(signals)]
            opened = _change(signals, changed)
            new = float(
                np.clip(strength * wanted / max(opened, 1e-9), effect.least(scales), effect.most(scales))
            )
            if abs(np.log(new / strength)) < 0.1:
                break
            strength = new
        answer["effects"] = {
            spike[0]: {
                "version": spike[1],
                "parameters": effect.described(sign * strength, shape),
                "gap_ratio": opened,
                "wanted": wanted,
            }
        }
        answer["gap_ratio"] = opened
    _write(source, changed, folder)
    return answer


def _signals(table: Table) -> Signals:
    time, displacement = table.signal("time"), table.signal("displacement")
    if time is None or displacement is None:
        raise UserError("A data set to be spiked needs the columns time and displacement in every file.")
    step = float((time[-1] - time[0]) / (len(time) - 1))
    silent = np.zeros(len(time))
    friction, base = table.signal("friction"), table.signal("base")
    velocity = np.gradient(displacement, step)
    return Signals(
        time=time - time[0],
        step=step,
        displacement=displacement,
        velocity=velocity,
        acceleration=np.gradient(velocity, step),
        friction=silent if friction is None else friction,
        base=silent if base is None else base,
    )


def _with(effect: Formulation, signals: Signals, strength: float, shape: Shape, index: int) -> Signals:
    changed = Signals(**vars(signals))
    effect.chain(changed, strength, shape, RunFacts(index, float(signals.time[-1])))
    return changed


def _noise(samples: Floats) -> float:
    """White noise from second differences, by their median."""
    return float(np.median(np.abs(np.diff(samples, 2)))) / 0.6745 / np.sqrt(6.0)


def _change(before: list[Signals], after: list[Signals]) -> float:
    """Root mean square change of the channel that changes, over its noise."""
    ratios = []
    for name in ("displacement", "friction"):
        pairs = [(getattr(one, name), getattr(two, name)) for one, two in zip(before, after, strict=True)]
        noise = float(np.median([_noise(one) for one, _ in pairs]))
        change = np.concatenate([two - one for one, two in pairs])
        floor = 1e-4 * float(np.ptp(np.concatenate([one for one, _ in pairs])))
        if change.any():
            ratios.append(float(np.sqrt(np.mean(change**2))) / max(noise, floor))
    return max(ratios, default=0.0)


def _scales(source: Source, signals: list[Signals]) -> Scales:
    rig = source.rig["rig"]
    mass = float(rig.get("mass_kg", 1.0))
    stiffness = float(rig.get("stiffness_n_per_m", 0.0))
    longest = max(float(one.time[-1]) for one in signals)
    period = 2.0 * np.pi * np.sqrt(mass / stiffness) if stiffness > 0.0 else 0.02 * longest
    strokes = [float(np.ptp(one.displacement)) / 2.0 for one in signals]
    speeds = [float(np.abs(one.velocity).max()) for one in signals]
    force = float(np.median([np.quantile(np.abs(one.friction), 0.99) for one in signals]))
    stroke, speed = float(np.median(strokes)), float(np.median(speeds))
    return Scales(
        mass=mass,
        stiffness=max(stiffness, force / stroke),
        damping=0.05 * mass / period,
        period=float(period),
        stroke=stroke,
        speed=speed,
        reach=max(strokes),
        haste=max(speeds),
        base=stroke,
        force=force,
        stick=0.01 * stroke,
        weakening=0.1 * speed,
        ring_damping=mass / period,
        interval=signals[0].step,
        duration=longest,
        lowest=1.0 / longest,
    )


def _write(source: Source, signals: list[Signals], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for (file, table), one in zip(source.tables.items(), signals, strict=True):
        numbers = table.numbers.copy()
        for quantity in ("displacement", "friction"):
            found = table.place(quantity)
            if found is not None:
                numbers[:, found[0]] = getattr(one, quantity) / found[1]
        place = folder / file
        place.parent.mkdir(parents=True, exist_ok=True)
        columns: list[Column] = []
        for index, name in enumerate(table.names):
            largest = 4.0 * float(np.abs(table.numbers[:, index]).max())
            whole = len(str(int(largest)))
            decimals = table.decimals[index]
            columns.append((name, numbers[:, index], decimals, whole + decimals + 2))
        write_table(place, columns)
    document = tomlkit.dumps({key: value for key, value in source.rig.items() if key != "name"})
    (folder / "rig.toml").write_text(document, encoding="utf-8", newline="\n")
