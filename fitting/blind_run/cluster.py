"""Cases on the workers of a Dask cluster that is there already."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

from distributed import Client, Future, KilledWorker, as_completed

from fitting.blind_run.case_work import Outcome, diagnose_sent
from jaxstick.errors import UserError
from jaxstick.sweeps.lost import ClusterLostError
from jaxstick.version import version

PATIENCE = 15.0
"""Seconds to wait for the scheduler's answer, and again for a first worker."""

AHEAD = 2
"""Cases under way for every thread of the workers."""


def on_cluster(folders: Mapping[str, Path], seed: int, address: str) -> Iterator[tuple[str, Outcome]]:
    """The outcome of every case by its name, in the order in which the workers finish them.

    The files travel with the case, so the workers need not share our disk. A case whose workers die one after
    the other is a failure of that case.

    Raises:
        UserError: where no scheduler answers within 15 s, it has no workers, or one of them lacks jaxstick or
            runs another version.
        ClusterLostError: where the scheduler goes away meanwhile.
    """
    with _client(address) as client:
        waiting = iter(folders.items())
        cases: dict[Future, str] = {}

        def send(name: str, folder: Path) -> Future:
            files = {
                path.relative_to(folder).as_posix(): path.read_bytes()
                for path in sorted(folder.rglob("*"))
                if path.is_file()
            }
            future = client.submit(diagnose_sent, name, files, seed, version(), pure=False)
            cases[future] = name
            return future

        threads = sum(client.nthreads().values())  # pyright: ignore[reportAttributeAccessIssue]
        first = [send(*item) for item in islice(waiting, AHEAD * max(threads, 1))]
        flying = as_completed(first)
        for future in flying:
            outcome = _outcome(future)
            name = cases.pop(future)
            future.release()
            following = next(waiting, None)
            if following is not None:
                flying.add(send(*following))
            yield name, outcome


def _outcome(future: Future) -> Outcome:
    try:
        return Outcome(*future.result())
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
