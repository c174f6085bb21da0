"""What a command says, and where: words and progress, and the result as JSON."""

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rich import box
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from jaxstick.output import to_json

WIDE = 160
"""Columns of a line that goes to a file or a pipe."""

WIDEST = 1000
"""Columns that a table may take."""


@dataclass(frozen=True)
class Terminal:
    """The common options of every command: quiet, whether the result is wanted as JSON, the seed.

    With `json` nothing but the result goes to standard output; words then go to standard error, like
    progress always does. With `quiet` there are neither.
    """

    quiet: bool = False
    json: bool = False
    seed: int = 0

    def progress_console(self) -> Console:
        """Where progress is shown."""
        return _console(to_stderr=True, quiet=self.quiet)

    def say(self, text: str = "", style: str = "") -> None:
        """One line of words, wrapped where the terminal ends."""
        self._words().print(Text(text, style), soft_wrap=not self._words().is_terminal)

    def bullets(self, sentences: Iterable[str], style: str = "") -> None:
        """Sentences, one below the other."""
        for sentence in sentences:
            self._words().print(Padding(Text(sentence, style), (0, 0, 0, 2), expand=False))

    def table(self, title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """A table of words; columns whose cells are all numbers or dashes are set to the right.

        A table is never squeezed: what a narrow terminal cannot show in a line goes on in the next.
        """
        cells = [tuple(row) for row in rows]
        table = Table(
            box=box.SIMPLE_HEAD,
            show_edge=False,
            padding=(0, 1, 0, 0),
        )
        for number, column in enumerate(columns):
            numeric = all(_is_number(row[number]) for row in cells)
            table.add_column(column, justify="right" if numeric else "left", vertical="bottom", no_wrap=True)
        for row in cells:
            table.add_row(*(Text(cell) for cell in row))
        words = self._words()
        words.print(Text(title, "bold"))
        words.width = WIDEST
        words.print(table)
        words.print()

    def result(self, value: Any) -> None:
        """The result, if it is wanted as JSON."""
        if self.json:
            sys.stdout.write(to_json(value))
            sys.stdout.flush()

    def _words(self) -> Console:
        return _console(to_stderr=self.json, quiet=self.quiet)


def stops_text(stops: float | None) -> str:
    """Stops a cycle: whole, or with one decimal where cycles differ; a dash for None."""
    return "-" if stops is None else f"{stops:.1f}".removesuffix(".0")


def _console(to_stderr: bool, quiet: bool) -> Console:
    stream = sys.stderr if to_stderr else sys.stdout
    width = None if stream.isatty() else WIDE
    return Console(file=stream, quiet=quiet, width=width, markup=False, emoji=False, highlight=False)


def _is_number(cell: str) -> bool:
    head = cell.lstrip("+-").partition(" ")[0]
    return cell in ("", "-") or (head[:1].isdigit() and head.replace(".", "").replace("e", "").isalnum())
