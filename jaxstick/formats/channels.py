"""The channels of one run's CSV file, in SI units on a uniform time axis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jaxstick.errors import UserError
from jaxstick.formats.table import read_table
from jaxstick.formats.timing import uniform_axis
from jaxstick.formats.units import CHANNELS, Named, column_quantity, spelled, spellings
from jaxstick.formats.words import did_you_mean, listed, shown

MIN_SAMPLES = 32
"""A record of fewer samples is refused."""

LARGEST = 1e30
"""Larger numbers, in SI units, are refused: their squares would overflow."""

REQUIRED = ("time", "displacement")


@dataclass(frozen=True)
class Channels:
    """What one CSV file holds.

    time: uniform [s]; interval [s]; values: SI samples by quantity (displacement, base, friction, force,
    velocity); units: the unit suffix in which each quantity was written; notices: sentences on what was left
    out or changed; sha256 of the file's bytes.
    """

    path: Path
    time: NDArray[np.float64]
    interval: float
    values: Mapping[str, NDArray[np.float64]]
    units: Mapping[str, str]
    notices: tuple[str, ...]
    sha256: str


def read_channels(path: Path) -> Channels:
    """Reads one run's CSV file.

    Raises:
        UserError: for everything `read_table` and `uniform_axis` refuse, for a missing or doubled quantity,
            an unknown unit, fewer than MIN_SAMPLES samples, and a channel that never changes.
    """
    header = _Header(path)
    table = read_table(path, header.select)
    count = len(table.lines)
    if count < MIN_SAMPLES:
        raise UserError(f"{path}: the file has {count} samples; at least {MIN_SAMPLES} are needed.")
    values = {
        quantity: samples * CHANNELS[quantity][header.units[quantity]]
        for quantity, samples in table.columns.items()
    }
    for quantity, samples in values.items():
        name = spelled(quantity, header.units[quantity])
        largest = np.abs(samples).max()
        if largest > LARGEST:
            raise UserError(
                f"{path}, column {name}: values reach {largest:.3g} (SI), more than any rig shows."
            )
        if quantity not in ("time", "force") and np.ptp(samples) == 0:
            raise UserError(
                f"{path}, column {name}: the channel never changes from {samples[0]:.6g} (SI): it is dead."
            )
    axis = uniform_axis(values.pop("time"), table.lines, str(path), CHANNELS["time"][header.units["time"]])
    return Channels(
        path,
        axis.time,
        axis.interval,
        {quantity: axis.resampled(samples) for quantity, samples in values.items()},
        header.units,
        (*header.notices, *([axis.notice] if axis.notice else [])),
        table.sha256,
    )


class _Header:
    """Finds the channels among a header's names, and remembers their units and what was left out."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.units: dict[str, str] = {}
        self.notices: list[str] = []

    def select(self, names: Sequence[str]) -> dict[str, int]:
        """The position of each quantity; raises UserError for a header that lacks or doubles one."""
        positions: dict[str, int] = {}
        for position, name in enumerate(names):
            column = column_quantity(name)
            if column is None:
                self._ignore(name)
                continue
            self._check_unit(name, column)
            if column.quantity in positions:
                raise UserError(
                    f"{self.path}: the columns {names[positions[column.quantity]]} and {name} both hold the "
                    f"quantity {column.quantity}; keep one."
                )
            positions[column.quantity] = position
            self.units[column.quantity] = column.unit
        for quantity in REQUIRED:
            if quantity not in positions:
                raise UserError(self._missing(quantity, names))
        return positions

    def _ignore(self, name: str) -> None:
        if name:
            hint = did_you_mean(name, spellings(CHANNELS))
            self.notices.append(f"{self.path}: the column {shown(name)} is not used{hint}.")

    def _check_unit(self, name: str, column: Named) -> None:
        if column.factor is not None:
            return
        allowed = listed(spelled(column.quantity, unit) for unit in CHANNELS[column.quantity])
        if not column.unit:
            raise UserError(
                f"{self.path}: the column {shown(name)} does not say its unit; call it {allowed}."
            )
        raise UserError(
            f"{self.path}: the unit of the column {shown(name)} is unknown; expected is {allowed}."
        )

    def _missing(self, quantity: str, names: Sequence[str]) -> str:
        allowed = [spelled(quantity, unit) for unit in CHANNELS[quantity]]
        for name in names:
            if hint := did_you_mean(name, allowed, f" for {shown(name)}"):
                return f"{self.path}: there is no column {listed(allowed)}{hint}."
        present = ", ".join(shown(name) for name in names[:12])
        return (
            f"{self.path}: there is no column {listed(allowed)} among {present}{'...' if names[12:] else ''}."
        )
