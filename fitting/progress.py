"""Progress of long computations, told to whoever wants to show it."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Is told which stage runs, how far it is and one number worth showing."""

    def stage(self, name: str, steps: int) -> None:
        """A new stage of about so many steps begins."""
        ...

    def advance(self, note: str = "") -> None:
        """One step of the present stage is done."""
        ...


class Silent:
    """Shows nothing."""

    def stage(self, name: str, steps: int) -> None:
        del name, steps

    def advance(self, note: str = "") -> None:
        del note
