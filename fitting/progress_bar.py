"""Progress on a terminal."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn


class ProgressBar:
    """Shows the stages of a computation: a bar on a terminal, one line a stage elsewhere.

    A context manager; it is what `fitting.progress.Progress` asks for.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bar = Progress(
            SpinnerColumn(),
            TextColumn("{task.description:<14}"),
            BarColumn(24),
            TimeElapsedColumn(),
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

    def advance(self, note: str = "") -> None:
        """One step of the present stage is done; the bar of a stage that takes more steps stays full."""
        self._bar.update(self._task, advance=1, note=note)
