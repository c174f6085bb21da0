"""A CSV file as columns of numbers.

Read: comma, semicolon or tab between cells (found from the header), decimal comma where the separator is not
the comma, `#` comments, blank lines. The file streams through in blocks, so that beside the resulting arrays
only a few MB are held.
"""

import csv
import hashlib
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from jaxstick.errors import UserError
from jaxstick.formats.files import opened
from jaxstick.formats.lines import Line, line_blocks
from jaxstick.formats.words import shown

MAX_BYTES = 512_000_000
"""Larger files are refused from their size alone."""

CUT_OFF = 0.9
"""A last line without a line end is cut off if more than this share of the rows end in a longer cell."""

SEPARATORS = (";", "\t", ",")

Numbers = NDArray[np.float64]
Select = Callable[[Sequence[str]], Mapping[str, int]]
"""Chooses columns: from the header's names to {key: position}; raises UserError where it cannot."""


@dataclass(frozen=True)
class Table:
    """The chosen columns of one CSV file.

    columns: arrays of equal length by the keys of `Select`; lines: the line of the file (from 1) on which
    each row stands; sha256: of the file's bytes, in hexadecimal.
    """

    path: Path
    columns: Mapping[str, Numbers]
    lines: NDArray[np.int64]
    sha256: str


def read_table(path: Path, select: Select) -> Table:
    """Reads the columns that `select` chooses from the header of a CSV file.

    Raises:
        UserError: for a file that cannot be read, is binary or cut off, and for a row of the wrong length or
            a chosen cell that is not a finite number; the sentence names the line and the column.
    """
    digest = hashlib.sha256()
    rows: _Rows | None = None
    with opened(path, MAX_BYTES) as stream:
        for block in line_blocks(stream, path, digest.update):
            lines = [line for line in block if (text := line.text.lstrip()) and text[0] != "#"]
            if rows is None and lines:
                rows = _Rows(path, lines.pop(0), select)
            if rows is not None:
                rows.take(lines)
    if rows is None:
        raise UserError(f"{path}: the file holds no header line.")
    if not rows.numbers:
        raise UserError(f"{path}: the file has a header but no samples below it.")
    columns = {key: np.concatenate(pieces) for key, pieces in rows.pieces.items()}
    return Table(path, columns, np.concatenate(rows.numbers), digest.hexdigest())


class _Rows:
    """The rows below a header: their chosen cells as numbers, block by block."""

    def __init__(self, path: Path, header: Line, select: Select) -> None:
        self.path = path
        self.separator = max(SEPARATORS, key=header.text.count)
        self.names = [cell.strip() for cell in self._split([header])[0]]
        if all(_is_number(name) for name in self.names):
            raise UserError(
                f"{path}, line {header.number}: numbers stand where column names such as time_s are expected."
            )
        self.chosen = select(self.names)
        self.pieces: dict[str, list[Numbers]] = {key: [] for key in self.chosen}
        self.numbers: list[NDArray[np.int64]] = []
        self._decimal_marks: set[str] = set()
        self._end_lengths: Counter[int] = Counter()

    def take(self, lines: list[Line]) -> None:
        """Reads some lines; those that hold nothing but separators are skipped."""
        lines = [line for line in lines if line.text.strip(" \t" + self.separator)]
        if not lines:
            return
        cells = self._split(lines)
        for line, row in zip(lines, cells, strict=True):
            if len(row) != len(self.names):
                self._refuse_row(line, len(row))
        self._check_end(lines[-1], [row[-1] for row in cells])
        for key, position in self.chosen.items():
            self.pieces[key].append(self._parse(key, lines, [row[position] for row in cells]))
        self.numbers.append(np.array([line.number for line in lines], dtype=np.int64))

    def _split(self, lines: list[Line]) -> list[list[str]]:
        texts = (line.text for line in lines)
        try:
            cells = list(csv.reader(texts, delimiter=self.separator, skipinitialspace=True))
        except csv.Error as error:
            raise UserError(
                f"{self.path}, after line {lines[0].number}: this is no CSV ({error})."
            ) from error
        if len(cells) != len(lines):
            first = next((line for line in lines if line.text.count('"') % 2), lines[0])
            raise UserError(f"{self.path}, line {first.number}: a quotation mark is opened and not closed.")
        return cells

    def _refuse_row(self, line: Line, found: int) -> NoReturn:
        where, width = f"{self.path}, line {line.number}", len(self.names)
        if not line.ended and found < width:
            raise UserError(f"{where}: the file seems cut off; its last line has {found} of {width} cells.")
        commas = self.separator == "," and found > width
        hint = " (decimal commas need ; or a tab between the cells)" if commas else ""
        raise UserError(f"{where}: the row has {found} cells where the header has {width}{hint}.")

    def _check_end(self, line: Line, cells: list[str]) -> None:
        """Refuses a file that stops, without a line end, in a cell shorter than nearly all above it."""
        ending = math.inf if line.ended else len(cells.pop())
        self._end_lengths.update(map(len, cells))
        longer = sum(count for length, count in self._end_lengths.items() if length > ending)
        if longer > CUT_OFF * self._end_lengths.total() and len(self.names) - 1 in self.chosen.values():
            raise UserError(
                f"{self.path}, line {line.number}: the file seems cut off inside its last number; if it is "
                "whole, end the line."
            )

    def _parse(self, key: str, lines: list[Line], cells: list[str]) -> Numbers:
        text = "".join(cells)
        if "," in text or "." in text:
            self._check_decimal_mark(key, text, lines, cells)
        if "," in text:
            cells = [cell.replace(",", ".") for cell in cells]
        # float() also reads 1_000 and the digits of other scripts.
        if text.isascii() and "_" not in text:
            try:
                values = np.array(list(map(float, cells)))
            except ValueError:
                self._refuse_cell(key, lines, cells)
            if np.isfinite(values).all():
                return values
        self._refuse_cell(key, lines, cells)

    def _check_decimal_mark(self, key: str, text: str, lines: list[Line], cells: list[str]) -> None:
        self._decimal_marks.update(mark for mark in ",." if mark in text)
        if len(self._decimal_marks) == 2:
            at = next(i for i, cell in enumerate(cells) if ("," if "," in text else ".") in cell)
            raise UserError(
                f"{self._where(lines[at], key)}: {shown(cells[at])} and other numbers of this file differ in "
                "their decimal mark, which must be the comma or the point throughout."
            )

    def _refuse_cell(self, key: str, lines: list[Line], cells: list[str]) -> NoReturn:
        at = next(i for i, cell in enumerate(cells) if not _is_finite_number(cell))
        where, cell = self._where(lines[at], key), cells[at]
        if not cell.strip():
            raise UserError(f"{where}: the cell is empty.")
        raise UserError(f"{where}: {shown(cell)} is not a {'finite ' if _is_number(cell) else ''}number.")

    def _where(self, line: Line, key: str) -> str:
        return f"{self.path}, line {line.number}, column {self.names[self.chosen[key]]}"


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return cell.isascii() and "_" not in cell


def _is_finite_number(cell: str) -> bool:
    return _is_number(cell) and math.isfinite(float(cell))
