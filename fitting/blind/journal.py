"""The answers of a set that is still being made: one encrypted line a case, so that a kill loses nothing."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fitting.blind.seal import lock, unlock
from jaxstick.errors import UserError

JOURNAL = "answers.partial"


class Journal:
    """The finished cases of a set in the making.

    Opening it reads what an earlier run has left. `plan` says what the set is; a journal of another plan or
    another key is refused with a UserError. A last line that a kill has cut off is dropped.
    """

    def __init__(self, folder: Path, key: str, plan: Mapping[str, Any]) -> None:
        self._path, self._key = folder / JOURNAL, key
        self.entries: dict[str, dict[str, Any]] = {}
        if self._path.exists():
            self._read(plan)
        else:
            self._append(dict(plan))

    def add(self, name: str, entry: Mapping[str, Any]) -> None:
        """Keeps what is to be remembered of a case."""
        self.entries[name] = dict(entry)
        self._append({"case": name, "entry": entry})

    def remove(self) -> None:
        """Takes the journal away once its content is sealed."""
        self._path.unlink(missing_ok=True)

    def _read(self, plan: Mapping[str, Any]) -> None:
        lines = self._path.read_bytes().splitlines(keepends=True)
        whole = [line for line in lines if line.endswith(b"\n")]
        if not whole:
            self._path.unlink()
            self._append(dict(plan))
            return
        if unlock(self._key, whole[0].strip(), self._path) != plan:
            raise UserError(
                f"{self._path.parent}: cases of another seed or other options were begun here; name another "
                "folder, or repeat the options."
            )
        for line in whole[1:]:
            kept = unlock(self._key, line.strip(), self._path)
            self.entries[kept["case"]] = kept["entry"]
        if len(whole) < len(lines):
            self._path.write_bytes(b"".join(whole))

    def _append(self, value: Any) -> None:
        with self._path.open("ab") as stream:
            stream.write(lock(self._key, value) + b"\n")
            stream.flush()
            os.fsync(stream.fileno())
