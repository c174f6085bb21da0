"""Chunks of lanes that are computed: kept on disk one file each, whole or not at all."""

import hashlib
import io
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jaxstick.errors import UserError
from jaxstick.output import atomic_write_bytes, atomic_write_text

Columns = Mapping[str, NDArray[Any]]

PLAN_FILE = "plan.json"

_CHUNK = re.compile(r"lanes-(\d+)-(\d+)\.chunk")


class Store:
    """The finished chunks of one sweep in a folder, each the columns of the lanes [first, last).

    A chunk's file holds the SHA-256 of what follows it and takes its name when it is on the disk; a file that
    does not agree with its checksum counts as not there. plan.json says whose chunks they are.
    """

    def __init__(self, folder: Path, fingerprint: str, lanes: int, overwrite: bool = False) -> None:
        """Goes on with what the folder holds of the sweep with this fingerprint.

        Raises UserError where the folder holds chunks of another sweep, unless `overwrite` lets them go.
        """
        self.folder = folder
        self.lanes = lanes
        whose = _fingerprint(folder / PLAN_FILE)
        present = [path for path in folder.iterdir() if _CHUNK.fullmatch(path.name)]
        if present and whose != fingerprint:
            if not overwrite:
                raise UserError(
                    f"{folder.parent}: an unfinished sweep with other settings is kept here; finish it with "
                    "the command that began it, or let --overwrite discard it."
                )
            for path in present:
                path.unlink()
        if whose != fingerprint:
            atomic_write_text(folder / PLAN_FILE, json.dumps({"schema": 1, "plan": fingerprint}) + "\n")
        self._kept = self._find()

    @property
    def kept(self) -> tuple[range, ...]:
        """The lanes of every finished chunk, in order, none twice."""
        return tuple(range(first, self._kept[first]) for first in sorted(self._kept))

    @property
    def finished(self) -> int:
        """How many lanes are finished."""
        return sum(map(len, self.kept))

    def pending(self, chunk: int) -> list[range]:
        """The lanes that are still to be computed, in order, at most `chunk` in one range."""
        gaps, after = [], 0
        for lanes in (*self.kept, range(self.lanes, self.lanes)):
            gaps.append((after, lanes.start))
            after = lanes.stop
        return [
            range(first, min(first + chunk, end)) for begin, end in gaps for first in range(begin, end, chunk)
        ]

    def keep(self, lanes: range, columns: Columns) -> None:
        """Writes a finished chunk; raises ValueError where a column has not one entry a lane."""
        for name, column in columns.items():
            if len(column) != len(lanes):
                raise ValueError(f"{len(column)} entries of {name} for {len(lanes)} lanes")
        content = io.BytesIO()
        arrays = {name: np.asarray(column) for name, column in columns.items()}
        np.savez(content, **arrays)  # pyright: ignore[reportArgumentType]
        data = content.getvalue()
        digest = hashlib.sha256(data).hexdigest().encode()
        atomic_write_bytes(self._path(lanes), digest + b"\n" + data)
        self._kept[lanes.start] = lanes.stop

    def read(self, lanes: range) -> dict[str, NDArray[Any]]:
        """The columns of a finished chunk.

        Raises UserError where its file no longer agrees with its checksum.
        """
        columns = _read(self._path(lanes))
        if columns is None:
            raise UserError(f"{self._path(lanes)}: this file was changed or removed; start the sweep again.")
        return columns

    def chunks(self) -> Iterator[dict[str, NDArray[Any]]]:
        """The columns of all finished chunks, in the order of their lanes."""
        return map(self.read, self.kept)

    def _path(self, lanes: range) -> Path:
        return self.folder / f"lanes-{lanes.start:08d}-{lanes.stop:08d}.chunk"

    def _find(self) -> dict[int, int]:
        """Ends of the finished chunks by their first lanes; a broken file is removed."""
        found: dict[int, int] = {}
        reached = 0
        for path in sorted(self.folder.iterdir()):
            named = _CHUNK.fullmatch(path.name)
            if named is None:
                continue
            first, last = int(named[1]), int(named[2])
            if first < reached or not first < last <= self.lanes or _read(path) is None:
                path.unlink()
                continue
            found[first] = reached = last
        return found


def _fingerprint(path: Path) -> str | None:
    try:
        return json.loads(path.read_text(encoding="utf-8"))["plan"]
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _read(path: Path) -> dict[str, NDArray[Any]] | None:
    """The columns in a chunk's file; None where the file is not whole."""
    try:
        digest, _, data = path.read_bytes().partition(b"\n")
    except OSError:
        return None
    if hashlib.sha256(data).hexdigest().encode() != digest:
        return None
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}
