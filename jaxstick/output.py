"""Writing results so that nothing of the user's is lost and nothing half-written is left."""

import dataclasses
import hashlib
import json
import math
import os
import secrets
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self, TextIO

import numpy as np

from jaxstick.errors import UserError
from jaxstick.formats.words import shown

try:
    import fcntl
except ImportError:
    fcntl = None

MARKER = ".jaxstick"
"""The file by which a folder of ours is known: JSON, the SHA-256 of every file we wrote by its path
inside."""

_NOT_THE_USERS = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})


def plain(value: Any) -> Any:
    """`value` in JSON's own types: arrays become lists, dataclasses objects, and numbers that are not finite
    null."""
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if hasattr(value, "__array__"):
        array = np.asarray(value)
        if array.dtype.kind in "biufU":
            return plain(array.tolist())
    raise TypeError(f"a {type(value).__name__} has no place in JSON")


def to_json(value: Any) -> str:
    """`value` as JSON text with a line end, after `plain`; raises TypeError for what JSON cannot hold."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


@contextmanager
def atomic_writer(path: Path) -> Iterator[TextIO]:
    """A UTF-8 text file (line ends \\n) that takes its name only when it is complete.

    Raises:
        UserError: where the operating system refuses.
    """
    part = _beside(path, "part")
    try:
        with part.open("x", encoding="utf-8", newline="\n") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(path)
    except OSError as error:
        raise _refused(path, error) from error
    finally:
        part.unlink(missing_ok=True)


def atomic_write_text(path: Path, text: str) -> None:
    """Writes a text file in one step; see `atomic_writer`."""
    with atomic_writer(path) as stream:
        stream.write(text)


def atomic_write_bytes(path: Path, data: bytes) -> None:
    """Writes a binary file in one step; see `atomic_writer`."""
    with atomic_writer(path) as stream:
        stream.buffer.write(data)


class OutputFolder:
    """A results folder that appears, or is replaced, only when the run that fills it has ended well.

    As a context manager it hands out a temporary folder beside the wanted one; whatever is written there
    moves into place at the end of the block. If the block raises, or the process dies, the old result stays
    whole.

        with OutputFolder(Path("out"), overwrite=True) as output:
            output.write_json("fit.json", result)
            figure.savefig(output.path("gap.png"))

    A long run goes on where an earlier one was killed if it is `resumable`: what it puts into the folder
    `kept` (in files that appear whole, see `atomic_writer`) stays until the result has moved into place.

    Args:
        path: the wanted folder. Its parents are made.
        overwrite: whether a folder that we wrote before may be replaced.
        inputs: files and folders the run reads; none of them may be the wanted folder or lie in it.
        resumable: whether there is a folder `kept`. One run at a time can then write to the wanted folder.

    Raises:
        UserError: on entering, if the wanted folder is a file, holds an input, holds a file that we did not
            write or that was changed since, holds a result of ours without `overwrite`, cannot be made, or is
            another resumable run's that is still going on. On leaving, if it became so meanwhile: the new
            result then stays in the temporary folder, which the sentence names.
    """

    def __init__(
        self, path: Path, overwrite: bool = False, inputs: Iterable[Path] = (), resumable: bool = False
    ) -> None:
        self.target = Path(path).resolve()
        self._shown = path
        self._overwrite = overwrite
        self._inputs = tuple(inputs)
        self._staging: Path | None = None
        self._workshop = Workshop(self.target, path) if resumable else None

    def __enter__(self) -> Self:
        try:
            self._restore()
            self._check()
            if self._workshop is None:
                staging = _beside(self.target, "part")
                staging.mkdir(parents=True)
            else:
                staging = self._workshop.open()
        except OSError as error:
            raise _refused(self._shown, error) from error
        self._staging = staging
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        staging, self._staging = self._entered(), None
        try:
            if kind is not None:
                shutil.rmtree(staging, ignore_errors=True)
                return
            self._finish(staging)
            if self._workshop is not None:
                self._workshop.empty()
        finally:
            if self._workshop is not None:
                self._workshop.close()

    def _finish(self, staging: Path) -> None:
        try:
            self._check()
            _mark(staging)
            self._move_in(staging)
        except UserError as refusal:
            raise UserError(f"{str(refusal).rstrip('.')}; the new results lie in {staging}.") from refusal
        except OSError as refusal:
            raise UserError(
                f"{self._shown}: this cannot be written ({refusal.strerror}); the new results lie in "
                f"{staging}."
            ) from refusal

    @property
    def folder(self) -> Path:
        """The temporary folder: what is written into it by the end of the block is the result."""
        return self._entered()

    @property
    def kept(self) -> Path:
        """Where a resumable run keeps what it has finished."""
        self._entered()
        if self._workshop is None:
            raise RuntimeError("only a resumable OutputFolder keeps anything")
        return self._workshop.kept

    def path(self, name: str) -> Path:
        """Where to write the file `name` (a relative path; its folders are made) before the block ends."""
        place = self.folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        return place

    def write_text(self, name: str, text: str) -> None:
        """Writes a text file; raises UserError where the operating system refuses."""
        try:
            self.path(name).write_text(text, encoding="utf-8", newline="\n")
        except OSError as error:
            raise _refused(Path(self._shown) / name, error) from error

    def write_json(self, name: str, value: Any) -> None:
        """Writes `to_json(value)`."""
        self.write_text(name, to_json(value))

    def _entered(self) -> Path:
        if self._staging is None:
            raise RuntimeError("an OutputFolder is used outside its with block")
        return self._staging

    @property
    def _old(self) -> Path:
        """Where the result that is being replaced stands for the moment of the exchange."""
        return self.target.with_name(f".{self.target.name}.jaxstick-old")

    def _restore(self) -> None:
        """Puts back a result whose replacement was killed between its two renames."""
        if not self.target.exists() and _written(self._old) is not None:
            self._old.rename(self.target)

    def _check(self) -> None:
        if not self.target.exists():
            return
        if not self.target.is_dir():
            raise UserError(f"{self._shown}: this is a file; results go to a folder.")
        for path in self._inputs:
            place = Path(path).resolve()
            if place == self.target or self.target in place.parents:
                raise UserError(f"{self._shown}: results may not replace {path}, which is read for them.")
        present = _files(self.target)
        if not present and not any(self.target.iterdir()):
            return
        written = _written(self.target)
        if written is None:
            raise UserError(
                f"{self._shown}: the folder is not empty and was not written by jaxstick; name another, or "
                "empty it."
            )
        if not self._overwrite:
            raise UserError(f"{self._shown}: the folder holds results already; --overwrite replaces them.")
        for name in present:
            if name not in written:
                raise UserError(
                    f"{self._shown}: {shown(name)} was not written by jaxstick; move it elsewhere first."
                )
            if written[name] != _sha256(self.target / name):
                raise UserError(
                    f"{self._shown}: {shown(name)} was changed since jaxstick wrote it; move it elsewhere."
                )

    def _move_in(self, staging: Path) -> None:
        if not self.target.exists():
            staging.rename(self.target)
        elif not any(self.target.iterdir()):
            # The empty folder stays the same folder: it may be some shell's current one. The marker goes
            # first: what a kill leaves behind is then known as ours.
            (staging / MARKER).rename(self.target / MARKER)
            for entry in sorted(staging.iterdir()):
                entry.rename(self.target / entry.name)
            staging.rmdir()
        else:
            if _written(self._old) is not None:
                shutil.rmtree(self._old)
            self.target.rename(self._old)
            staging.rename(self.target)
            shutil.rmtree(self._old)


class Workshop:
    """The hidden folder beside a results folder in which a resumable run works.

    `kept` holds what the run has finished and outlives it; the result is put together in a second folder,
    which an end by exception or kill leaves worthless. A lock, which ends with the process that holds it,
    lets one run in at a time (where the operating system has such locks).
    """

    def __init__(self, target: Path, shown_as: Path) -> None:
        self.folder = target.with_name(f".{target.name}.jaxstick-unfinished")
        self.kept = self.folder / "kept"
        self._shown = shown_as
        self._lock: IO[bytes] | None = None

    def open(self) -> Path:
        """Takes the lock and hands out the empty folder for the result.

        Raises UserError where another run has the lock.
        """
        self.kept.mkdir(parents=True, exist_ok=True)
        self._lock = (self.folder / "lock").open("wb")
        try:
            _lock(self._lock)
        except BlockingIOError as error:
            self._lock.close()
            self._lock = None
            raise UserError(f"{self._shown}: another jaxstick is at work on this folder.") from error
        staging = self.folder / "result"
        shutil.rmtree(staging, ignore_errors=True)
        staging.mkdir()
        return staging

    def empty(self) -> None:
        """Throws away what is kept."""
        shutil.rmtree(self.kept, ignore_errors=True)

    def close(self) -> None:
        """Lets go of the lock; nothing of the folder stays where nothing is kept."""
        if not self.kept.exists() or not any(self.kept.iterdir()):
            shutil.rmtree(self.folder, ignore_errors=True)
        if self._lock is not None:
            self._lock.close()
            self._lock = None


def _lock(stream: IO[bytes]) -> None:
    """Locks an open file against other processes; raises BlockingIOError where one has locked it."""
    if fcntl is not None:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _mark(folder: Path) -> None:
    files = {name: _sha256(folder / name) for name in _files(folder)}
    (folder / MARKER).write_text(to_json({"schema": 1, "files": files}), encoding="utf-8")


def _files(folder: Path) -> list[str]:
    """Everything in a folder but folders, the marker and the file manager's litter: sorted relative paths."""
    found = (path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())
    names = (path.relative_to(folder).as_posix() for path in found if path.name not in _NOT_THE_USERS)
    return sorted(name for name in names if name != MARKER)


def _written(folder: Path) -> dict[str, str] | None:
    """The marker's list of files, or None where there is no marker of ours."""
    try:
        marker = json.loads((folder / MARKER).read_text(encoding="utf-8"))
        files = marker["files"]
        return {str(name): str(digest) for name, digest in files.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _beside(path: Path, purpose: str) -> Path:
    """A new hidden name in the folder of `path`."""
    return path.with_name(f".{path.name}.jaxstick-{purpose}-{secrets.token_hex(4)}")


def _refused(path: Path, error: OSError) -> UserError:
    return UserError(f"{path}: this cannot be written ({error.strerror or error}).")
