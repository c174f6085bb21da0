"""The seal on the answers: encrypted, with checksums of the cases they belong to.

A set of cases is a folder: one data set per case, `answers.sealed` with the answers, encrypted (Fernet: AES
in CBC mode with an HMAC), and `manifest.json` with the SHA-256 of the sealed file and of every file of every
case. The key is not in the folder.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cryptography.fernet import Fernet, InvalidToken

from jaxstick.errors import UserError
from jaxstick.output import atomic_write_bytes, atomic_write_text, to_json

SEALED = "answers.sealed"
MANIFEST = "manifest.json"
SCHEMA = 1


@dataclass(frozen=True)
class Opened:
    """The content of a seal: the answer to every case by its name, and the manifest."""

    answers: Mapping[str, Mapping[str, Any]]
    manifest: Mapping[str, Any]


def new_key() -> str:
    """A fresh key, 44 characters."""
    return Fernet.generate_key().decode()


def lock(key: str, value: Any) -> bytes:
    """A JSON value under lock; raises UserError for what is no key."""
    return _fernet(key).encrypt(to_json(value).encode())


def unlock(key: str, token: bytes, where: Path) -> Any:
    """What `lock` locked; raises UserError where the key is another one or the token was changed."""
    try:
        return json.loads(_fernet(key).decrypt(token))
    except InvalidToken as error:
        raise UserError(f"{where}: this key does not open it; it was sealed with another.") from error


def _fernet(key: str) -> Fernet:
    try:
        return Fernet(key.strip())
    except ValueError as error:
        raise UserError(
            "The key is not one of ours: expected are the 44 characters that `jaxstick blind make` gave."
        ) from error


def read_key(path: Path) -> str:
    """The key in a file; raises UserError where it cannot be read."""
    try:
        return path.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: the key cannot be read from it.") from error


def checksums(folder: Path) -> dict[str, str]:
    """SHA-256 of every file below a folder, by its path inside."""
    return {
        path.relative_to(folder).as_posix(): sha256(path)
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def sha256(path: Path) -> str:
    """The SHA-256 of a file in hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def seal(
    folder: Path,
    key: str,
    answers: Mapping[str, Any],
    files: Mapping[str, Mapping[str, str]],
    about: Mapping[str, Any],
) -> None:
    """Writes the sealed answers and the manifest.

    files: checksums of the files of every case; about: what else the manifest says.
    """
    token = lock(key, {"schema": SCHEMA, "answers": answers})
    atomic_write_bytes(folder / SEALED, token)
    manifest = {
        "schema": SCHEMA,
        **about,
        "seal": {"file": SEALED, "sha256": hashlib.sha256(token).hexdigest()},
        "cases": files,
    }
    atomic_write_text(folder / MANIFEST, to_json(manifest))


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a set of cases; raises UserError where there is none."""
    path = folder / MANIFEST
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        if manifest["schema"] != SCHEMA:
            raise UserError(
                f"{path}: its schema is {manifest['schema']}; this version of jaxstick reads {SCHEMA}."
            )
        if not isinstance(manifest["seal"]["sha256"], str) or not isinstance(manifest["cases"], dict):
            raise TypeError
    except OSError as error:
        raise UserError(f"{folder}: there is no {MANIFEST}; this is no finished set of cases.") from error
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: this is not the manifest of a set of cases.") from error
    return manifest


def open_seal(folder: Path, key: str) -> Opened:
    """The answers of a set of cases, after everything was compared with its checksum.

    Raises:
        UserError: where the sealed file or a file of a case is missing or was changed, and for another key.
    """
    manifest = read_manifest(folder)
    path = folder / SEALED
    try:
        token = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: the sealed answers are missing.") from error
    if hashlib.sha256(token).hexdigest() != manifest["seal"]["sha256"]:
        raise UserError(f"{path}: the sealed answers were changed; their checksum is not the manifest's.")
    check_cases(folder, manifest)
    answers = unlock(key, token, path)["answers"]
    return Opened(answers, manifest)


def check_cases(folder: Path, manifest: Mapping[str, Any]) -> None:
    """Raises UserError for the first case that is missing or of which a file was changed."""
    for name, files in manifest["cases"].items():
        case = folder / name
        if not case.is_dir():
            raise UserError(f"{case}: the case is missing, though the manifest lists it.")
        for file, checksum in files.items():
            place = case / file
            if not place.is_file():
                raise UserError(f"{place}: the file is missing, though the manifest lists it.")
            if sha256(place) != checksum:
                raise UserError(f"{place}: the file was changed; its checksum is not the manifest's.")
