"""The results of a set of sealed cases: one folder a case with diagnosis.json, or why there is none.

The head of the folder, blind.json, says whose results they are: the checksum of the sealed answers and the
seed of the diagnosis. Nothing is written into the folders of the cases.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jaxstick.errors import UserError
from jaxstick.output import atomic_write_text, to_json
from jaxstick.version import version

HEAD = "blind.json"
DIAGNOSIS = "diagnosis.json"
FAILURE = "failure.json"
SCHEMA = 1


def default_results(folder: Path) -> Path:
    """Where the results of a set go by default: DIR-results, beside the set."""
    whole = folder.resolve()
    return whole.with_name(f"{whole.name}-results")


def data_checksum(files: Mapping[str, str]) -> str:
    """The checksum of a case as a data set, from those of its files: what `jaxstick.record.load_dataset`
    gives for a folder that holds nothing but its data."""
    lines = "".join(f"{files[name]}  {name}\n" for name in sorted(files))
    return hashlib.sha256(lines.encode()).hexdigest()


class Results:
    """A folder of results. `begin` makes it or goes on in it; without, it is read alone."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def begin(self, manifest: Mapping[str, Any], seed: int, overwrite: bool) -> None:
        """Makes the folder ready for the results of a set.

        Raises UserError where it holds something else, or results of another set, seed or version without
        `overwrite`, which lets go of all results in it.
        """
        head = {**_whose(manifest), "seed": seed, "version": version()}
        found = self._head()
        try:
            if found is None:
                if self.folder.exists() and any(self.folder.iterdir()):
                    raise UserError(
                        f"{self.folder}: the folder is not empty and holds no results of sealed cases; name "
                        "another."
                    )
                self.folder.mkdir(parents=True, exist_ok=True)
            elif overwrite:
                self._clear()
            elif found != head:
                raise UserError(
                    f"{self.folder}: the results in it are of another set, seed or version of jaxstick; name "
                    "another folder, or let --overwrite discard them."
                )
        except OSError as error:
            raise UserError(f"{self.folder}: this cannot be written ({error.strerror}).") from error
        atomic_write_text(self.folder / HEAD, to_json(head))

    def check(self, manifest: Mapping[str, Any]) -> None:
        """Raises UserError where there are no results, or those of another set."""
        found = self._head()
        if found is None:
            raise UserError(f"{self.folder}: there are no results here; `jaxstick blind run` makes them.")
        if {name: found.get(name) for name in _whose(manifest)} != _whose(manifest):
            raise UserError(f"{self.folder}: the results in it are of another set of cases.")

    def keep(self, case: str, diagnosis: str) -> None:
        """Keeps the text of a diagnosis; a failure that was recorded before goes."""
        place = self.folder / case
        place.mkdir(exist_ok=True)
        atomic_write_text(place / DIAGNOSIS, diagnosis)
        (place / FAILURE).unlink(missing_ok=True)

    def keep_failure(self, case: str, sentence: str) -> None:
        """Keeps why there is no diagnosis."""
        place = self.folder / case
        place.mkdir(exist_ok=True)
        atomic_write_text(place / FAILURE, to_json({"case": case, "error": sentence}))

    def read(self, case: str, files: Mapping[str, str]) -> dict[str, Any] | None:
        """The diagnosis of a case; None where there is none or it is not whole or of other data.

        files: checksums of the case's files.
        """
        try:
            content = json.loads((self.folder / case / DIAGNOSIS).read_text(encoding="utf-8"))
            sums = sum(content["probabilities"].values())
            named = all(isinstance(key, str) for key in content["named"])
            whole = content["schema"] == SCHEMA and isinstance(content["verdict"], str) and named
            own = content["data"]["sha256"] == data_checksum(files)
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return None
        return content if whole and own and abs(sums - 1.0) < 1e-3 else None

    def failure(self, case: str) -> str | None:
        """Why a case has no diagnosis, if that was recorded."""
        try:
            return str(json.loads((self.folder / case / FAILURE).read_text(encoding="utf-8"))["error"])
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def _head(self) -> dict[str, Any] | None:
        try:
            head = json.loads((self.folder / HEAD).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return head if isinstance(head, dict) and head.get("schema") == SCHEMA else None

    def _clear(self) -> None:
        for name in (DIAGNOSIS, FAILURE):
            for path in self.folder.glob(f"*/{name}"):
                path.unlink()


def _whose(manifest: Mapping[str, Any]) -> dict[str, Any]:
    return {"schema": SCHEMA, "seal_sha256": manifest["seal"]["sha256"]}
