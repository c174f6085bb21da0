"""corrected_rig.toml: a correction as a rig file that the simulator, a sweep and another fit take."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import tomlkit

from fitting.against import stated
from fitting.correction import RIG_NUMBERS, Correction, shifted
from fitting.result import Constant
from fitting.unknowns import RIG
from jaxstick.cycle import cycle_of
from jaxstick.nominal import effects_of
from jaxstick.output import OutputFolder
from jaxstick.parameter import parameters
from jaxstick.record import DataSet, KnownRig, Run, rig_document
from jaxstick.version import version

CORRECTED_FILE = "corrected_rig.toml"

WIDTH = 100
DIGITS = 10
"""Figures of a drive that is read off a record."""

Entry = tuple[float, float | None, float | None]
"""A value with the ends of its 95 % interval, None where the data do not bound it."""


def save_corrected(
    correction: Correction,
    dataset: DataSet,
    output: OutputFolder,
    head: Sequence[str],
    found: Mapping[str, Entry],
) -> None:
    """Writes corrected_rig.toml into the folder; see `corrected_rig`."""
    output.write_text(CORRECTED_FILE, corrected_rig(correction, dataset, head, found))


def entries(constants: Iterable[Constant]) -> dict[str, Entry]:
    """Fitted constants by name."""
    return {constant.name: (constant.value, constant.low, constant.high) for constant in constants}


def corrected_rig(
    correction: Correction, dataset: DataSet, head: Sequence[str], found: Mapping[str, Entry]
) -> str:
    """The text of the rig file: the rig, constants and effects of the correction with all their digits, and
    the runs of the data set under the names of their files.

    head: sentences on where this comes from; found: what was fitted, under the names of the unknowns ("A",
    "rig.mass", "effect.parameter"), whose intervals stand beside the values. A run that was recorded gets the
    sine, length and sampling of its record, so that it can be simulated without it.
    """
    corrected = dataclasses.replace(
        dataset,
        rig=correction.rig,
        assumed=correction.constants,
        effects=correction.effects,
        runs=tuple(_run(run, correction, dataset.rig) for run in dataset.runs),
        rig_file=None,
    )
    document = rig_document(corrected, _head(head))
    _remark_on_rig(document["rig"], correction.rig, dataset.rig, found)
    _remark_on_constants(document["assumed"], dataset, found)
    _remark_on_effects(document.get("effects", {}), corrected, dataset, found)
    for table, run in zip(document["run"], dataset.runs, strict=True):  # pyright: ignore[reportArgumentType]
        _remark_on_run(table, run)
    return tomlkit.dumps(document)


def _head(sentences: Sequence[str]) -> str:
    lines = [
        f"Written by jaxstick {version()}. A corrected rig: simulator and records agree better with it.",
        *sentences,
        "It is used as any rig file: jaxstick simulate and sweep take it, and so do, for the records it "
        "lists, jaxstick simulate DATASET --rig and jaxstick fit DATASET --rig, DATASET being their folder. "
        "Put in the place of the data set's own rig.toml it does the same.",
    ]
    printable = ("".join(each if each.isprintable() else " " for each in line) for line in lines)
    return "\n".join(line for sentence in printable for line in textwrap.wrap(sentence, WIDTH))


def _run(run: Run, correction: Correction, stated_rig: KnownRig) -> Run:
    """The run with the corrected rig and constants, and with the sine that its record shows where none is
    stated."""
    cycle = None if run.frequency is not None and run.base_amplitude is not None else cycle_of(run)
    drive = {}
    if cycle is not None and cycle.base_amplitude:
        drive = {
            "frequency": run.frequency or _rounded(cycle.frequency),
            "base_amplitude": run.base_amplitude or _rounded(cycle.base_amplitude),
            "base_phase": run.base_phase or _rounded(cycle.phase),
        }
    rig = shifted(correction, run.rig, stated_rig)
    return dataclasses.replace(run, rig=rig, assumed=correction.constants, **drive)


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _remark_on_rig(table: Any, rig: KnownRig, known: KnownRig, found: Mapping[str, Entry]) -> None:
    for (name, before), key in zip(dataclasses.asdict(known).items(), list(table), strict=True):
        if name in RIG_NUMBERS and getattr(rig, name) != before:
            _remark(table[key], _interval(found.get(f"{RIG}{name}")), f"stated: {stated(before)}")


def _remark_on_constants(table: Any, dataset: DataSet, found: Mapping[str, Entry]) -> None:
    for (name, before), key in zip(dataclasses.asdict(dataset.assumed).items(), list(table), strict=True):
        was = "" if before is None else f"assumed: {stated(before)}"
        _remark(table[key], _interval(found.get(name)), was)


def _remark_on_effects(tables: Any, corrected: DataSet, dataset: DataSet, found: Mapping[str, Entry]) -> None:
    for key, effect in effects_of(corrected).items():
        tables[key].comment(effect.card.title)
        given = dataset.effects.get(key, {})
        for place in parameters(effect):
            name, kind = place.path[-1], place.parameter
            meaning = kind.meaning if kind.unit == "1" else f"{kind.unit}, {kind.meaning}"
            entry = found.get(f"{key}.{name}")
            was = f"stated: {stated(given[name])}" if name in given else "" if entry else "not fitted"
            _remark(tables[key][name], meaning, _interval(entry), was)


def _remark_on_run(table: Any, run: Run) -> None:
    """The length and the sampling of the record, by which it is simulated where the record is not there."""
    table.add("duration_s", _rounded((len(run.time) - 1) * run.interval))
    table.add("sample_rate_hz", _rounded(1 / run.interval))
    if "frequency_hz" not in table:
        table["file"].comment("no single sine drives this run, so a simulation of it needs the record")
    elif run.frequency is None:
        table["frequency_hz"].comment("as the record shows")


def _interval(entry: Entry | None) -> str:
    if entry is None:
        return ""
    _, low, high = entry
    if low is None and high is None:
        return "not bounded by the records"
    return f"95 %: {' to '.join('?' if end is None else stated(end) for end in (low, high))}"


def _remark(item: Any, *words: str) -> None:
    """Puts what there is of these words behind a value."""
    said = "; ".join(filter(None, words))
    if said:
        item.comment(said)
