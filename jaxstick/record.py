"""Records: what is known of a rig, what was measured on it, and a data set of both.

A data set is a folder: rig.toml says what is known, one CSV file per run holds the samples. Everything here
is in SI units and float64.
"""

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from numpy.typing import ArrayLike, NDArray
from tomlkit import TOMLDocument
from tomlkit.items import Table

from jaxstick.errors import UserError
from jaxstick.formats.channels import Channels, read_channels
from jaxstick.formats.plausibility import Stated, check_record
from jaxstick.formats.rig_toml import DAMPINGS, RigTables, RunTable, read_rig_toml
from jaxstick.output import atomic_write_text, atomic_writer

RIG_FILE = "rig.toml"

_ROWS_AT_ONCE = 1 << 16


@dataclass(frozen=True)
class KnownRig:
    """What is known of the oscillator m x'' + c x' + K x = k_d y + c_d y' + u + F.

    mass m [kg]; stiffness K [N/m], total; drive_stiffness k_d [N/m]; damping c [N s/m], total; drive_damping
    c_d [N s/m]; friction_against: the surface that rubs, "ground" or "base".
    """

    mass: float
    stiffness: float
    drive_stiffness: float
    damping: float
    drive_damping: float
    friction_against: str = "ground"

    @property
    def natural_frequency(self) -> float:
        """sqrt(K/m) / (2 pi) [Hz]."""
        return math.sqrt(self.stiffness / self.mass) / (2 * math.pi)


@dataclass(frozen=True)
class AssumedConstants:
    """The friction constants in use today: A [N], B [s/m], C [N], D [N s/m], k1 [N/m]; None where nothing is
    said."""

    A: float | None = None
    B: float | None = None
    C: float | None = None
    D: float | None = None
    k1: float | None = None


@dataclass(frozen=True)
class Noise:
    """Standard deviation of each channel's noise, in SI units; None where nothing is said."""

    displacement: float | None = None
    friction: float | None = None
    base: float | None = None
    force: float | None = None
    velocity: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """One record. Arrays have shape (samples,) and are read-only; None where a channel was not recorded.

    time: uniform [s]; displacement x, base y [m]; friction: the force on the mass, opposing its motion [N];
    force: the applied force u [N]; velocity [m/s]. frequency [Hz], base_amplitude [m] and base_phase [rad] as
    stated: y = base_amplitude sin(2 pi frequency time + base_phase) where the base was not recorded. rig and
    assumed hold for this run: the data set's with the run's own overrides. hold_out: never used for fitting.
    """

    file: str
    time: NDArray[np.float64]
    displacement: NDArray[np.float64]
    friction: NDArray[np.float64] | None = None
    base: NDArray[np.float64] | None = None
    force: NDArray[np.float64] | None = None
    velocity: NDArray[np.float64] | None = None
    frequency: float | None = None
    base_amplitude: float | None = None
    base_phase: float = 0.0
    hold_out: bool = False
    rig: KnownRig
    assumed: AssumedConstants = AssumedConstants()

    def __post_init__(self) -> None:
        for name in ("time", *CHANNEL_NAMES):
            given: ArrayLike | None = getattr(self, name)
            if given is not None:
                samples = np.array(given, dtype=np.float64)
                if samples.shape != np.shape(self.time) or samples.ndim != 1 or len(samples) < 2:
                    raise ValueError(
                        f"{self.file}: {name} has the shape {samples.shape}, time {np.shape(self.time)}"
                    )
                samples.flags.writeable = False
                object.__setattr__(self, name, samples)

    @property
    def interval(self) -> float:
        """Time from one sample to the next [s]."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))

    @property
    def channels(self) -> dict[str, NDArray[np.float64]]:
        """The recorded channels by name, time excepted."""
        recorded = {name: getattr(self, name) for name in CHANNEL_NAMES}
        return {name: samples for name, samples in recorded.items() if samples is not None}


CONSTANTS = tuple(each.name for each in fields(AssumedConstants))
"""A, B, C, D, k1."""

CHANNEL_NAMES = tuple(each.name for each in fields(Noise))
"""displacement, friction, base, force, velocity."""

Effects = Mapping[str, Mapping[str, float]]
"""Effects as rig.toml states them: their parameters [SI] by name under their keys. What is not given is at
its null or in its usual shape; whether there are such effects is the shelf's business."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DataSet:
    """Runs of one rig.

    name: the folder's, or as rig.toml says; noise: as stated; effects: taken to act on the rig beside its
    friction; notices: sentences on what was assumed, left out or changed in reading; sha256: of rig.toml and
    all CSV files, independent of the order in which they are listed. folder, sha256 and rig_file, where the
    rig was read from, are None for a data set that was not read from files.
    """

    name: str
    rig: KnownRig
    assumed: AssumedConstants = AssumedConstants()
    noise: Noise = Noise()
    runs: tuple[Run, ...]
    notices: tuple[str, ...] = ()
    folder: Path | None = None
    sha256: str | None = None
    effects: Effects = field(default_factory=dict)
    rig_file: Path | None = None


@dataclass(frozen=True, kw_only=True)
class RunPlan:
    """One [[run]] of rig.toml without its record: what a simulation of it needs.

    frequency, sample_rate [Hz]; base_amplitude [m]; base_phase [rad]; the length as duration [s] or cycles of
    the drive; None where nothing is said.
    """

    file: str
    frequency: float | None = None
    base_amplitude: float | None = None
    base_phase: float = 0.0
    duration: float | None = None
    cycles: float | None = None
    sample_rate: float | None = None
    hold_out: bool = False
    rig: KnownRig
    assumed: AssumedConstants = AssumedConstants()


@dataclass(frozen=True, kw_only=True)
class RigSheet:
    """rig.toml alone: what is known, and the runs it lists (perhaps none). sha256 of the file."""

    path: Path
    name: str
    rig: KnownRig
    assumed: AssumedConstants
    noise: Noise
    runs: tuple[RunPlan, ...]
    notices: tuple[str, ...]
    sha256: str
    effects: Effects = field(default_factory=dict)


def load_rig(path: Path) -> RigSheet:
    """Reads rig.toml, named itself or by its folder, without any record.

    Raises:
        UserError: for everything `read_rig_toml` refuses and for a mass or stiffness that is missing.
    """
    path = _existing(Path(path))
    if path.is_dir():
        if not _exists(path / RIG_FILE):
            raise UserError(f"{path}: the folder holds no {RIG_FILE}, which says what is known of the rig.")
        path = path / RIG_FILE
    tables = read_rig_toml(path)
    rig, notices = _known_rig(tables.rig, path, "[rig]")
    runs = tuple(_plan(run, tables) for run in tables.runs)
    name = tables.name or path.absolute().parent.name or path.stem
    return RigSheet(
        path=path,
        name=name,
        rig=rig,
        assumed=AssumedConstants(**tables.assumed),
        noise=Noise(**tables.noise),
        runs=runs,
        notices=tuple(notices),
        sha256=tables.sha256,
        effects=tables.effects,
    )


def load_dataset(folder: Path, rig: Path | None = None) -> DataSet:
    """Reads a data set: rig.toml and every CSV file it names.

    rig: a file to be read in place of the folder's rig.toml; the files that it names are in the folder.

    Raises:
        UserError: for everything `load_rig`, `read_channels` and `check_record` refuse, for no runs or none
            to fit, and for a run that nothing drives.
    """
    folder = _existing(Path(folder))
    if not folder.is_dir():
        raise UserError(f"{folder}: this is a file; a data set is a folder with {RIG_FILE} and CSV files.")
    sheet = load_rig(folder if rig is None else rig)
    if not sheet.runs:
        raise UserError(f"{sheet.path}: no run is listed; each record needs a section [[run]] with its file.")
    if all(plan.hold_out for plan in sheet.runs):
        raise UserError(f"{sheet.path}: every run has hold_out = true, so none is left to fit.")
    notices = list(sheet.notices)
    runs: list[Run] = []
    digests = {RIG_FILE: sheet.sha256}
    for plan in sheet.runs:
        record = read_channels(folder / plan.file)
        digests[plan.file] = record.sha256
        _check_drive(plan, record)
        notices += [*record.notices, *check_record(record, _stated(plan))]
        runs.append(_run(plan, record))
    return DataSet(
        name=sheet.name,
        rig=sheet.rig,
        assumed=sheet.assumed,
        noise=sheet.noise,
        runs=tuple(runs),
        notices=tuple(notices),
        folder=folder,
        sha256=_combined(digests),
        effects=sheet.effects,
        rig_file=sheet.path,
    )


def save_dataset(dataset: DataSet, folder: Path, comment: str = "") -> None:
    """Writes a data set that `load_dataset` reads back to the same numbers.

    The folder is made if it is missing. comment: lines for the head of rig.toml.

    Raises:
        UserError: where a file of one of the names exists already or cannot be written.
    """
    folder = Path(folder)
    for name in (RIG_FILE, *(run.file for run in dataset.runs)):
        place = folder / name
        if _exists(place):
            raise UserError(f"{place}: the file exists already; a data set is written into a new folder.")
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(
                f"{place.parent}: the folder cannot be made ({error.strerror or error})."
            ) from error
    for run in dataset.runs:
        with atomic_writer(folder / run.file) as stream:
            stream.writelines(_csv_lines(run))
    atomic_write_text(folder / RIG_FILE, tomlkit.dumps(rig_document(dataset, comment)))


def rig_document(dataset: DataSet, comment: str = "") -> TOMLDocument:
    """rig.toml of a data set, with these lines at its head."""
    document = tomlkit.document()
    for line in comment.splitlines():
        document.add(tomlkit.comment(line))
    document.add("name", tomlkit.item(dataset.name))
    document.add("rig", _table(asdict(dataset.rig), _RIG_KEYS))
    for name, values, keys in (
        ("assumed", asdict(dataset.assumed), _ASSUMED_KEYS),
        ("noise", asdict(dataset.noise), _COLUMNS),
    ):
        if any(value is not None for value in values.values()):
            document.add(name, _table(values, keys))
    if dataset.effects:
        effects = tomlkit.table(is_super_table=True)
        for key, values in dataset.effects.items():
            effects.add(key, _table(values, {name: name for name in values}))
        document.add("effects", effects)
    runs = tomlkit.aot()
    for run in dataset.runs:
        runs.append(_run_table(run, dataset))
    document.add("run", runs)
    return document


def _existing(path: Path) -> Path:
    if not _exists(path):
        raise UserError(f"{path}: there is no such file or folder.")
    return path


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError as error:
        raise UserError(f"{path}: this cannot be opened ({error.strerror or error}).") from error


def _known_rig(values: Mapping[str, Any], path: Path, where: str) -> tuple[KnownRig, list[str]]:
    """The rig and notices on it. Damping: zeta = log_decrement / (2 pi), c = 2 zeta sqrt(K m)."""
    for key, name in (("mass", "mass_kg"), ("stiffness", "stiffness_n_per_m")):
        if key not in values:
            raise UserError(f"{path}: {where} lacks {name}.")
    mass, stiffness = values["mass"], values["stiffness"]
    notices = []
    ratio = values.get("damping_ratio")
    if "log_decrement" in values:
        ratio = values["log_decrement"] / (2 * math.pi)
    if ratio is not None and stiffness == 0:
        raise UserError(
            f"{path}: {where} has stiffness 0, where only damping_n_s_per_m says how much damping there is."
        )
    damping = values.get("damping", 0.0) if ratio is None else 2 * ratio * math.sqrt(stiffness * mass)
    if not any(name in values for name in DAMPINGS):
        notices.append(f"{path}: {where} gives no damping; it is taken as 0.")
    rig = KnownRig(
        mass,
        stiffness,
        values.get("drive_stiffness", stiffness),
        damping,
        values.get("drive_damping", 0.0),
        values.get("friction_against", "ground"),
    )
    if rig.drive_stiffness > rig.stiffness:
        notices.append(
            f"{path}: {where} has a drive stiffness above the total stiffness, of which it is a part."
        )
    if rig.drive_damping > rig.damping * (1 + 1e-9):
        notices.append(f"{path}: {where} has a drive damping above the total damping, of which it is a part.")
    return rig, notices


def _plan(run: RunTable, tables: RigTables) -> RunPlan:
    inherited = dict(tables.rig)
    if any(name in run.rig for name in DAMPINGS):
        inherited = {name: value for name, value in inherited.items() if name not in DAMPINGS}
    rig, _ = _known_rig({**inherited, **run.rig}, tables.path, f"[rig] of the run {run.file}")
    return RunPlan(
        file=run.file,
        **run.values,
        hold_out=run.hold_out,
        rig=rig,
        assumed=AssumedConstants(**{**tables.assumed, **run.assumed}),
    )


def _check_drive(plan: RunPlan, record: Channels) -> None:
    based = "base" in record.values or (plan.frequency is not None and plan.base_amplitude is not None)
    if not based and "force" not in record.values:
        found = (
            "has a frequency but no base amplitude"
            if plan.frequency is not None
            else "has a base amplitude but no frequency"
            if plan.base_amplitude is not None
            else "says nothing of the drive"
        )
        raise UserError(
            f"{record.path}: the run {found}, and its file has neither a base nor a force column; give "
            "frequency_hz and base_amplitude_mm, or the channel."
        )
    if plan.rig.stiffness == 0 and "force" not in record.values and plan.rig.friction_against == "ground":
        raise UserError(
            f"{record.path}: with stiffness 0 only an applied force can move the mass, and there is no "
            "column force_n."
        )


def _stated(plan: RunPlan) -> Stated:
    return Stated(
        plan.rig.stiffness,
        plan.rig.drive_stiffness,
        plan.rig.friction_against,
        plan.frequency,
        plan.base_amplitude,
    )


def _run(plan: RunPlan, record: Channels) -> Run:
    return Run(
        file=plan.file,
        time=record.time,
        **record.values,
        frequency=plan.frequency,
        base_amplitude=plan.base_amplitude,
        base_phase=plan.base_phase,
        hold_out=plan.hold_out,
        rig=plan.rig,
        assumed=plan.assumed,
    )


def _combined(digests: Mapping[str, str]) -> str:
    """One checksum for several files: the SHA-256 of their names and checksums in the order of the names."""
    lines = "".join(f"{digests[name]}  {name}\n" for name in sorted(digests))
    return hashlib.sha256(lines.encode()).hexdigest()


_COLUMNS = {
    "time": "time_s",
    "base": "base_m",
    "displacement": "displacement_m",
    "velocity": "velocity_m_per_s",
    "friction": "friction_n",
    "force": "force_n",
}
_RIG_KEYS = {
    "mass": "mass_kg",
    "stiffness": "stiffness_n_per_m",
    "drive_stiffness": "drive_stiffness_n_per_m",
    "damping": "damping_n_s_per_m",
    "drive_damping": "drive_damping_n_s_per_m",
    "friction_against": "friction_against",
}
_ASSUMED_KEYS = {"A": "A_n", "B": "B_s_per_m", "C": "C_n", "D": "D_n_s_per_m", "k1": "k1_n_per_m"}


def _csv_lines(run: Run) -> Iterator[str]:
    """The run as CSV lines; numbers in the shortest form that reads back to the same float64."""
    recorded = {name: getattr(run, name) for name in _COLUMNS if getattr(run, name) is not None}
    yield ",".join(_COLUMNS[name] for name in recorded) + "\n"
    for first in range(0, len(run.time), _ROWS_AT_ONCE):
        cells = (map(repr, samples[first : first + _ROWS_AT_ONCE].tolist()) for samples in recorded.values())
        for row in zip(*cells, strict=True):
            yield ",".join(row) + "\n"


def _run_table(run: Run, dataset: DataSet) -> Table:
    table = tomlkit.table()
    table.add("file", run.file)
    if run.frequency is not None:
        table.add("frequency_hz", run.frequency)
    if run.base_amplitude is not None:
        table.add("base_amplitude_m", run.base_amplitude)
    if run.base_phase:
        table.add("base_phase_rad", run.base_phase)
    table.add("hold_out", run.hold_out)
    for name, own, common, keys in (
        ("rig", asdict(run.rig), asdict(dataset.rig), _RIG_KEYS),
        ("assumed", asdict(run.assumed), asdict(dataset.assumed), _ASSUMED_KEYS),
    ):
        overrides = {key: value for key, value in own.items() if value != common[key]}
        if None in overrides.values():
            raise ValueError(f"{run.file}: a run cannot lack a constant that its data set assumes")
        if overrides:
            inline = tomlkit.inline_table()
            inline.update({keys[key]: value for key, value in overrides.items()})
            table.add(name, inline)
    return table


def _table(values: Mapping[str, Any], keys: Mapping[str, str]) -> Table:
    table = tomlkit.table()
    for name, value in values.items():
        if value is not None:
            table.add(keys[name], value)
    return table
