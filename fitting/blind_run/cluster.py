"""Cases on the workers of a Dask cluster that is there already."""

from __future__ import annotations

import logging
import queue
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

from distributed import Client, Future, KilledWorker

from fitting.blind_run.case_work import Outcome, diagnose_sent
from jaxstick.errors import UserError
from jaxstick.sweeps.lost import ClusterLostError
from jaxstick.version import version

PATIENCE = 15.0
"""Seconds to wait for the scheduler's answer, and again for a first worker."""

AHEAD = 2
"""Cases under way for every thread of the workers."""

DESERTED = 120.0
"""Seconds without any worker after which a run that is under way gives up."""

LOOK = 2.0
"""Seconds between two looks whether the cluster is still there."""


def on_cluster(folders: Mapping[str, Path], seed: int, address: str) -> Iterator[tuple[str, Outcome]]:
    """The outcome of every case by its name, in the order in which the workers finish them.

    The files travel with the case, so the workers need not share our disk. A case whose workers die one after
    the other is a failure of that case.

    Raises:
        UserError: where no scheduler answers within 15 s, it has no workers, or one of them lacks jaxstick or
            runs another version.
        ClusterLostError: where the scheduler goes away meanwhile, or has no worker for two minutes.
    """
    with _client(address) as client:
        waiting = iter(folders.items())
        done: queue.SimpleQueue[Future] = queue.SimpleQueue()
        flying: dict[Future, str] = {}

        def send(name: str, folder: Path) -> None:
            files = {
                path.relative_to(folder).as_posix(): path.read_bytes()
                for path in sorted(folder.rglob("*"))
                if path.is_file()
            }
            future = client.submit(diagnose_sent, name, files, seed, version(), pure=False)
            flying[future] = name
            future.add_done_callback(done.put)

        threads = sum(client.nthreads().values())  # pyright: ignore[reportAttributeAccessIssue]
        for item in islice(waiting, AHEAD * max(threads, 1)):
            send(*item)
        while flying:
            future = _next(client, done)
            name = flying.pop(future)
            outcome = _outcome(future)
            future.release()
            following = next(waiting, None)
            if following is not None:
                send(*following)
            yield name, outcome


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


def _outcome(future: Future) -> Outcome:
    try:
        return Outcome(*future.result(timeout=DESERTED))
    except KilledWorker:
        return Outcome(None, "The case has killed one worker of the cluster after the other.")
    except ModuleNotFoundError as error:
        raise UserError(
            f"A worker of the cluster lacks the package {error.name}; install this version of jaxstick on "
            "all of them."
        ) from error
    except (CancelledError, TimeoutError, OSError) as error:
        raise ClusterLostError("the connection to the Dask scheduler is lost") from error


@contextmanager
def _client(address: str) -> Iterator[Client]:
    silenced = [logging.getLogger(name) for name in ("asyncio", "distributed", "tornado")]
    levels = [logger.level for logger in silenced]
    for logger in silenced:
        logger.setLevel(logging.CRITICAL + 1)
    try:
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
    finally:
        for logger, level in zip(silenced, levels, strict=True):
            logger.setLevel(level)
