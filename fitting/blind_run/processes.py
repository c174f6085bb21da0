"""Cases on all cores: one process a core, each on one thread, so that what kills one costs one case."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import NamedTuple

from fitting.blind_run.case_work import Outcome

try:
    import resource
except ImportError:
    resource = None

MOST_MEMORY, ENOUGH_MEMORY, OURS = 3e9, 8e9, 0.5
"""A process that has had more than so much memory [bytes] is replaced by a fresh one after its case: compiled
programs pile up. It may have more, up to the second, where all together take no larger share of what there
is than this."""

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "NPROC": "1",
}
"""Environment that keeps BLAS, numba and XLA from sharing one case among cores that others work on."""

EIGEN = "--xla_cpu_multi_thread_eigen=false"

Act = Callable[[Path, int], Outcome]


def on_cores(folders: Mapping[str, Path], seed: int, workers: int, act: Act) -> Iterator[tuple[str, Outcome]]:
    """The outcome of every case by its name, in the order in which they are finished.

    `act` is called with the case's folder and the seed in a process of its own kind (spawned); it has to be a
    function that can be imported. A process that dies is a failure of its case alone.
    """
    waiting, memory = iter(folders.items()), most_memory(_installed(), workers)
    crew: list[_Worker] = []
    with _one_thread_each():
        try:
            for name, folder in waiting:
                crew.append(_Worker.hired(act, memory))
                crew[-1].begin(name, folder, seed)
                if len(crew) >= workers:
                    break
            while crew:
                for worker in _ready(crew):
                    case = worker.case
                    report = worker.report()
                    following = next(waiting, None)
                    crew.remove(worker)
                    if following is not None:
                        if report.spent:
                            worker.dismiss()
                            worker = _Worker.hired(act, memory)
                        worker.begin(*following, seed)
                        crew.append(worker)
                    else:
                        worker.dismiss()
                    yield case, report.outcome
        finally:
            for worker in crew:
                worker.stop()


class _Report(NamedTuple):
    outcome: Outcome
    spent: bool


class _Worker:
    """A process and our end of the line to it."""

    def __init__(self, process: BaseProcess, line: Connection) -> None:
        self._process, self.line = process, line
        self.case = ""

    @classmethod
    def hired(cls, act: Act, memory: float) -> _Worker:
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, act, memory), daemon=True)
        process.start()
        theirs.close()
        return cls(process, ours)

    def begin(self, case: str, folder: Path, seed: int) -> None:
        self.case = case
        try:
            self.line.send((folder, seed))
        except OSError:
            return  # It is dead; `report` says so.

    def report(self) -> _Report:
        try:
            return _Report(*self.line.recv())
        except (EOFError, OSError):
            self._process.join()
            return _Report(Outcome(None, _death(self._process.exitcode or 0)), True)

    def dismiss(self) -> None:
        """Lets the process go once it has nothing to do."""
        self.line.close()
        self._process.join()

    def stop(self) -> None:
        """Ends the process in the middle of its case."""
        self._process.kill()
        self.dismiss()


def _ready(crew: Sequence[_Worker]) -> list[_Worker]:
    ready = wait([worker.line for worker in crew])
    return [worker for worker in crew if worker.line in ready]


def _death(code: int) -> str:
    how = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
    return f"The process that diagnosed it ended {how}."


def _serve(line: Connection, act: Act, memory: float) -> None:
    """The life of a process: cases come in, outcomes go out, and whether it has had more than so much memory,
    until the line is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while True:
        try:
            outcome = act(*line.recv())
            line.send((outcome, _memory() > memory))
        except (EOFError, OSError):
            return


def most_memory(installed: float, workers: int) -> float:
    """How much memory [bytes] each of so many processes may have had before it is replaced, where so much is
    installed (0: not known)."""
    return min(max(OURS * installed / workers, MOST_MEMORY), ENOUGH_MEMORY)


def _installed() -> int:
    """The memory of this machine [bytes]; 0 where that is not known."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return 0


def _memory() -> int:
    """The most memory that this process has had [bytes]; 0 where that is not known."""
    if resource is None:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes that are started meanwhile use one thread each."""
    flags = os.environ.get("XLA_FLAGS", "")
    changed = {**ONE_THREAD, "XLA_FLAGS": f"{flags} {EIGEN}".strip()}
    before = {name: os.environ.get(name) for name in changed}
    os.environ.update(changed)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
