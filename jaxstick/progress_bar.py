"""Progress on a terminal."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)


class ProgressBar:
    """Shows the stages of a computation: a bar on a terminal, one line a stage elsewhere.

    A context manager; it is what `fitting.progress.Progress` asks for. `remaining` adds an estimate of the
    time left, for stages whose steps take equally long.
    """

    def __init__(self, console: Console, remaining: bool = False) -> None:
        self._console = console
        columns: list[ProgressColumn] = [
            SpinnerColumn(),
            TextColumn("{task.description:<14}"),
            BarColumn(24),
            TimeElapsedColumn(),
        ]
        if remaining:
            columns += [TextColumn("left:"), TimeRemainingColumn()]
        self._bar = Progress(
            *columns,
            TextColumn("{task.fields[note]}", style="dim"),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._task = self._bar.add_task("", total=None, note="", visible=False)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def stage(self, name: str, steps: int) -> None:
        """A new stage of about so many steps begins."""
        if self._console.is_terminal:
            self._bar.reset(self._task, description=name, total=max(steps, 1), note="", visible=True)
        else:
            self._console.print(f"{name} ...")

    def advance(self, note: str = "", steps: int = 1) -> None:
        """So many steps of the present stage are done; the bar of a stage that takes more stays full."""
        self._bar.update(self._task, advance=steps, note=note)
