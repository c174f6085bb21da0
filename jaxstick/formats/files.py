"""Opening the user's files: every way this can fail is a sentence."""

import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from jaxstick.errors import UserError


@contextmanager
def opened(path: Path, limit: int) -> Iterator[BinaryIO]:
    """The regular file `path`, open for reading as bytes.

    A directory, a pipe, an empty file and one of more than `limit` bytes are refused before anything is read.

    Raises:
        UserError: for all of these, and where the operating system refuses.
    """
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise UserError(f"{path}: this is a folder where a file is expected.")
        if not stat.S_ISREG(status.st_mode):
            raise UserError(f"{path}: this is not an ordinary file.")
        if status.st_size == 0:
            raise UserError(f"{path}: the file is empty.")
        if status.st_size > limit:
            raise UserError(
                f"{path}: the file has {status.st_size / 1e6:.0f} MB, more than the {limit / 1e6:.0f} MB "
                "that are read."
            )
        with path.open("rb") as stream:
            yield stream
    except FileNotFoundError as error:
        raise UserError(f"{path}: there is no such file.") from error
    except PermissionError as error:
        raise UserError(f"{path}: the file may not be read (permission denied).") from error
    except OSError as error:
        raise UserError(f"{path}: the file cannot be read ({error.strerror or error}).") from error
