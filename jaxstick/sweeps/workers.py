"""Tasks on the workers of a Dask cluster that is there already: the connection, and what is under way."""

from __future__ import annotations

import logging
import queue
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from typing import Any, TypeVar

from distributed import Client, Future

from jaxstick.errors import UserError
from jaxstick.sweeps.lost import ClusterLostError

PATIENCE = 15.0
"""Seconds to wait for the scheduler's answer, and again for a first worker."""

DESERTED = 120.0
"""Seconds without any worker after which work that is under way is given up."""

AHEAD = 2
"""Tasks under way for every thread of the workers, so that none waits for us."""

LOOK = 2.0
"""Seconds between two looks whether the cluster is still there."""

Task = TypeVar("Task")
Result = TypeVar("Result")


@contextmanager
def client_of(address: str) -> Iterator[Client]:
    """A client of the Dask scheduler at `address`, with workers.

    Raises UserError where no scheduler answers there within 15 s, or it has no worker after 15 s more.
    """
    with _silenced():
        try:
            client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise UserError(f"{address}: no Dask scheduler answers there within {PATIENCE:g} s.") from error
        try:
            try:
                client.wait_for_workers(1, timeout=PATIENCE)
            except TimeoutError as error:
                raise UserError(
                    f"{address}: the Dask scheduler there has no workers; none came within {PATIENCE:g} s."
                ) from error
            yield client
        finally:
            client.close(timeout=5)


def finished(
    client: Client,
    tasks: Iterable[Task],
    submit: Callable[[Task], Future],
    result: Callable[[Future], Result],
) -> Iterator[tuple[Task, Result]]:
    """Every task with its result, in the order in which the workers finish them.

    At most `AHEAD` tasks for each worker thread are under way, so memory does not grow with their number.

    Raises ClusterLostError where the scheduler goes away, or no worker has been left for two minutes.
    """
    waiting = iter(tasks)
    done: queue.SimpleQueue[Future] = queue.SimpleQueue()
    flying: dict[Future, Task] = {}

    def send(task: Task) -> None:
        future = submit(task)
        flying[future] = task
        future.add_done_callback(done.put)

    threads = sum(client.nthreads().values())  # pyright: ignore[reportAttributeAccessIssue]
    for task in islice(waiting, AHEAD * max(threads, 1)):
        send(task)
    while flying:
        future = _next(client, done)
        task = flying.pop(future)
        found = result(future)
        future.release()
        for following in islice(waiting, 1):
            send(following)
        yield task, found


def result_of(future: Future) -> Any:
    """What a task returned.

    Raises UserError where a worker lacks jaxstick or what it needs, ClusterLostError where the scheduler went
    away, and distributed.KilledWorker where the task's workers died one after the other.
    """
    try:
        return future.result(timeout=DESERTED)
    except ModuleNotFoundError as error:
        raise UserError(
            f"A worker of the cluster lacks the package {error.name}; install this version of jaxstick on "
            "all of them."
        ) from error
    except (CancelledError, TimeoutError, OSError) as error:
        raise ClusterLostError("the connection to the Dask scheduler is lost") from error


def _next(client: Client, done: queue.SimpleQueue[Future]) -> Future:
    """The next future that has ended, one way or the other."""
    seen = time.monotonic()
    while True:
        try:
            return done.get(timeout=LOOK)
        except queue.Empty:
            if client.status == "closed":
                raise ClusterLostError("the connection to the Dask scheduler is lost") from None
            if _has_workers(client):
                seen = time.monotonic()
            elif time.monotonic() - seen > DESERTED:
                raise ClusterLostError(
                    f"the Dask scheduler has had no workers for {DESERTED:.0f} s"
                ) from None


def _has_workers(client: Client) -> bool:
    try:
        return bool(client.nthreads())
    except (OSError, TimeoutError, ValueError):
        return False


@contextmanager
def _silenced() -> Iterator[None]:
    """Without what distributed and its event loop log; what goes wrong is said by us."""
    names = [name for name in logging.root.manager.loggerDict if name.split(".")[0] in _TALKATIVE]
    loggers = [logging.getLogger(name) for name in (*_TALKATIVE, *names)]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


_TALKATIVE = ("asyncio", "distributed", "tornado")
