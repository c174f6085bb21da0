"""The lanes of a sweep as files, written lane by lane: sweep.json, and the same as CSV."""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from jaxstick.output import plain

Columns = Mapping[str, NDArray[Any]]


def write_tables(
    json_stream: TextIO,
    csv_stream: TextIO,
    head: Mapping[str, Any],
    chunks: Iterable[Columns],
    records: Callable[[Columns], list[dict[str, Any]]],
) -> None:
    """Writes `head` and the lanes of all chunks to both streams.

    `records` makes the entries of a chunk's lanes in JSON's own types. The JSON object holds the head's keys
    and behind them `lanes`, one lane a line. The CSV has the columns of the chunks, those of a wide one
    numbered (harmonics_1 ... harmonics_9), and an empty cell where JSON has null; the head is not in it.
    """
    json_stream.write("{\n")
    for key, value in head.items():
        json_stream.write(f"  {_compact(key)}: {_compact(plain(value))},\n")
    json_stream.write('  "lanes": [')
    between = "\n"
    for number, chunk in enumerate(chunks):
        for record in records(chunk):
            json_stream.write(f"{between}    {_compact(record)}")
            between = ",\n"
        flat = _flat(chunk)
        if number == 0:
            csv_stream.write(",".join(flat) + "\n")
        rows = zip(*(map(_cell, column.tolist()) for column in flat.values()), strict=True)
        csv_stream.writelines(",".join(row) + "\n" for row in rows)
    json_stream.write("\n  ]\n}\n")


def _compact(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _flat(chunk: Columns) -> dict[str, NDArray[Any]]:
    """The columns, a wide one as several; not a number where a lane has no period."""
    flat: dict[str, NDArray[Any]] = {}
    for name, column in chunk.items():
        if column.ndim == 1:
            flat[name] = np.where(column > 0, column, np.nan) if name == "period" else column
        else:
            parts = column.reshape(len(column), -1).T
            flat |= {f"{name}_{number}": part for number, part in enumerate(parts, start=1)}
    return flat


def _cell(value: float) -> str:
    """The number as short as it reads back the same; whole numbers without a point."""
    if not math.isfinite(value):
        return ""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
