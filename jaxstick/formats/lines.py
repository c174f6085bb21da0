"""A text file as numbered lines, in blocks: bytes in, text out, nothing of its meaning."""

import codecs
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

from jaxstick.errors import UserError

BLOCK_BYTES = 1 << 21
"""Text is decoded in blocks of about this size."""

MAX_LINE_BYTES = 1 << 20
"""A longer line is refused: what has one is no table."""


class Line(NamedTuple):
    """One line of a file: its number from 1, its text, and whether a line end follows it."""

    number: int
    text: str
    ended: bool = True


def line_blocks(stream: BinaryIO, path: Path, seen: Callable[[bytes], object]) -> Iterator[list[Line]]:
    """Blocks of whole lines of a UTF-8 file, with or without byte order mark, with any line ends.

    Args:
        stream: the open file.
        path: its name, for messages.
        seen: is handed every byte read, in order.

    Raises:
        UserError: for a binary file, for text that is not UTF-8, and for a line longer than MAX_LINE_BYTES.
    """
    number, rest = 1, b""
    first = True
    while read := stream.read(BLOCK_BYTES):
        seen(read)
        if first:
            if read.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
                raise UserError(f"{path}: the file is UTF-16 text; save it as UTF-8.")
            read = read.removeprefix(codecs.BOM_UTF8)
            first = False
        if b"\0" in read:
            raise UserError(f"{path}: this is a binary file, not text.")
        data = rest + read
        # A carriage return at the very end may be the first half of a Windows line end.
        end = max(data.rfind(b"\n"), data.rfind(b"\r", 0, -1)) + 1
        if len(data) - end > MAX_LINE_BYTES:
            raise UserError(f"{path}, line {number}: the line is longer than {MAX_LINE_BYTES} bytes.")
        texts = _decoded(data[:end], path, number)
        yield [Line(number + i, text) for i, text in enumerate(texts[:-1])]
        number += len(texts) - 1
        rest = data[end:]
    *whole, last = _decoded(rest, path, number)
    yield [
        *(Line(number + i, text) for i, text in enumerate(whole)),
        *([Line(number + len(whole), last, False)] if last else []),
    ]


def _decoded(data: bytes, path: Path, first_line: int) -> list[str]:
    """The text split at line ends; the last piece is what follows the last line end."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        line, byte = first_line + data.count(b"\n", 0, error.start), data[error.start]
        raise UserError(
            f"{path}, line {line}: the byte 0x{byte:02x} is no UTF-8; save the file as UTF-8."
        ) from error
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
