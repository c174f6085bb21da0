"""A piece of work in a second process, while this one goes on with something else."""

from __future__ import annotations

import contextlib
import multiprocessing
import signal
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Any, Self

from jaxstick.deferred import Deferred


class Aside:
    """A process that does one piece of work aside, as a context manager.

    It is there from the beginning of the block, and imports what the work takes meanwhile, so that the work
    starts at once when it begins:

        with Aside(draw) as drawing:
            found = compute()
            drawing.begin(found)
            write(found)
            drawing.end()

    Whatever fails there, the process itself too, is done once more here, and fails here if it has to. So the
    work, which can be imported, may be done twice; what it takes can be pickled, and what it returns is lost.
    """

    def __init__(self, work: Deferred) -> None:
        self._work = work
        self._process: BaseProcess | None = None
        self._line: Connection | None = None
        self._args: tuple[Any, ...] = ()

    def __enter__(self) -> Self:
        context = multiprocessing.get_context("spawn")
        self._line, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, self._work), daemon=True)
        with contextlib.suppress(OSError):  # There is none; `end` does the work.
            process.start()
            self._process = process
        theirs.close()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        del kind, error, trace
        if self._line is not None:
            self._line.close()
        if self._process is not None:
            self._process.kill()
            self._process.join()

    def begin(self, *args: Any) -> None:
        """Lets the work be done with these arguments."""
        self._args = args
        with contextlib.suppress(OSError):  # It is dead; `end` does the work.
            self._entered().send(args)

    def end(self) -> None:
        """Waits until the work is done."""
        try:
            done = self._entered().recv()
        except (EOFError, OSError):
            done = False
        if not done:
            self._work(*self._args)

    def _entered(self) -> Connection:
        if self._line is None:
            raise RuntimeError("there is a second process within the `with` block only")
        return self._line


def _serve(line: Connection, work: Deferred) -> None:
    """The life of the process: it gets ready, and does its work once, or goes when nobody needs it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        work.load()
        work(*line.recv())
    except EOFError:
        return
    except Exception:
        line.send(False)
    else:
        line.send(True)
