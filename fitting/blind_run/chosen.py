"""Some of the cases of a set, by their numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jaxstick.errors import UserError


def chosen(folder: Path, manifest: Mapping[str, Any], numbers: Sequence[int] | None) -> list[str]:
    """The names of the cases with these numbers, in order; raises UserError for one that is not there."""
    by_number = {int(name.rpartition("-")[2]): name for name in sorted(manifest["cases"])}
    if numbers is None:
        return list(by_number.values())
    for number in numbers:
        if number not in by_number:
            raise UserError(
                f"{folder}: there is no case {number}; the set has {len(by_number)}, from "
                f"{min(by_number, default=0)} to {max(by_number, default=0)}."
            )
    return [by_number[number] for number in sorted(set(numbers))]
