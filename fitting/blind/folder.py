"""Writing a case as a data set: every file of the same form, whatever its effect."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from tomlkit.items import Table

from fitting.blind.formulation import Floats
from fitting.blind.recipe import Recipe
from fitting.blind.recorder import recorded
from fitting.blind.statement import PER_SI
from fitting.blind.truth import driven, seen_drive

DIGITS = 8
"""Significant digits of the numbers in rig.toml."""


def write_case(recipe: Recipe, folder: Path) -> None:
    """Writes rig.toml and one CSV file per run into an empty folder.

    All numbers of a column have the same width and as many decimals as the converter's step calls for, which
    comes from the rig without effects: neither sizes nor digits of the files depend on the effect.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for index in range(len(recipe.runs)):
        write_table(folder / file_name(index), _columns(recipe, index))
    (folder / "rig.toml").write_text(_rig_toml(recipe), encoding="utf-8", newline="\n")


def file_name(index: int) -> str:
    """The name of the run's file."""
    return f"run-{index + 1:02d}.csv"


Column = tuple[str, Floats, int, int]
"""A column's name, its numbers in the unit of the name, decimals and width."""


def write_table(path: Path, columns: list[Column]) -> None:
    """Writes a CSV file of columns of even width."""
    texts = [
        [f"{value:+0{width}.{decimals}f}" for value in numbers.tolist()]
        for _, numbers, decimals, width in columns
    ]
    with path.open("w", encoding="utf-8", newline="\n") as stream:
        stream.write(",".join(name for name, *_ in columns) + "\n")
        stream.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))


def _columns(recipe: Recipe, index: int) -> list[Column]:
    time = np.asarray(recipe.interval * np.arange(recipe.runs[index].samples), dtype=np.float64)
    columns: list[Column] = [("time_s", time, 5, 10)]
    channels = {"base": recipe.base, "displacement": recipe.displacement, "friction": recipe.friction}
    for name, samples in recorded(recipe, index).items():
        channel = channels[name]
        if channel is not None:
            scaled = samples * PER_SI[channel.unit]
            columns.append((f"{name}_{channel.unit}", scaled, channel.decimals, channel.width))
    return columns


def _rig_toml(recipe: Recipe) -> str:
    document = tomlkit.document()
    document.add("rig", _table(recipe.stated["rig"]))
    document.add("assumed", _table(recipe.stated["assumed"]))
    if recipe.stated["noise"]:
        document.add("noise", _table(recipe.stated["noise"]))
    runs = tomlkit.aot()
    for index, plan in enumerate(recipe.runs):
        run: dict[str, Any] = {"file": file_name(index)}
        if recipe.stated["frequency"]:
            run["frequency_hz"] = plan.frequency
        if recipe.base is None:
            amplitude = seen_drive(recipe, index, driven(recipe, plan)).amplitude
            run["base_amplitude_mm"] = amplitude * PER_SI["mm"]
        runs.append(_table(run))
    document.add("run", runs)
    return tomlkit.dumps(document)


def _table(values: Mapping[str, Any]) -> Table:
    table = tomlkit.table()
    for name, value in values.items():
        table.add(name, float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value)
    return table
