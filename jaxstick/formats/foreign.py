"""CSV files of other laboratories whose columns have names of their own but are in SI units already."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jaxstick.errors import UserError
from jaxstick.formats.table import read_table
from jaxstick.formats.timing import uniform_axis
from jaxstick.formats.words import shown


def read_foreign(path: Path, columns: Mapping[str, str]) -> dict[str, NDArray[np.float64]]:
    """Channels by quantity, `time` among them, on a uniform time axis.

    Args:
        path: the file.
        columns: the column's name in the file for each quantity.

    Raises:
        UserError: for what `read_table` and `uniform_axis` refuse, and for a missing column.
    """

    def select(names: Sequence[str]) -> dict[str, int]:
        for column in columns.values():
            if column not in names:
                raise UserError(
                    f"{path}: there is no column {shown(column)} among {', '.join(map(shown, names))}."
                )
        return {quantity: names.index(column) for quantity, column in columns.items()}

    table = read_table(path, select)
    if len(table.lines) < 2:
        raise UserError(f"{path}: the file has a single sample.")
    values = dict(table.columns)
    axis = uniform_axis(values.pop("time"), table.lines, str(path))
    return {"time": axis.time} | {quantity: axis.resampled(samples) for quantity, samples in values.items()}
