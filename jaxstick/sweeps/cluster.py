"""Chunks of a sweep on the workers of a Dask cluster that is there already."""

from __future__ import annotations

import logging
import pickle
import queue
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from functools import partial
from itertools import islice
from typing import Any

from distributed import Client, Future, KilledWorker

from jaxstick.errors import UserError
from jaxstick.sweeps.lost import ClusterLostError
from jaxstick.sweeps.task import compute_pickled
from jaxstick.version import version

PATIENCE = 15.0
"""Seconds to wait for the scheduler's answer, and again for a first worker."""

DESERTED = 120.0
"""Seconds without any worker after which a sweep that is under way gives up."""

AHEAD = 2
"""Chunks under way for every thread of the workers, so that none waits for us."""

LOOK = 2.0
"""Seconds between two looks whether the cluster is still there."""


@contextmanager
def connected(address: str) -> Iterator[Callable[..., Iterator[tuple[range, Any]]]]:
    """The workers of the Dask scheduler at `address`, as a function that computes ranges of lanes.

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
            yield partial(_on_cluster, client)
        finally:
            client.close(timeout=5)


def _on_cluster(
    client: Client, points: Any, pending: Sequence[range], derivatives: Sequence[str]
) -> Iterator[tuple[range, Any]]:
    """The columns of every range of lanes of `points`, in the order in which the workers finish them.

    At most two chunks for each worker thread are under way, so memory does not grow with the sweep. What a
    worker had when it died is computed again by another; a chunk whose workers die one after another (as
    often as the scheduler allows, three times by default) ends the sweep.

    Raises UserError where a worker lacks jaxstick or runs another version; ClusterLostError where the
    scheduler goes away, a chunk kills its workers, or no worker has been left for two minutes.
    """
    waiting = iter(pending)
    done: queue.SimpleQueue[Future] = queue.SimpleQueue()
    flying: dict[Future, range] = {}

    def send(lanes: range) -> None:
        data = pickle.dumps(points[lanes.start : lanes.stop])
        future = client.submit(compute_pickled, data, tuple(derivatives), version(), pure=False)
        flying[future] = lanes
        future.add_done_callback(done.put)

    threads = sum(client.nthreads().values())  # pyright: ignore[reportAttributeAccessIssue]
    for lanes in islice(waiting, AHEAD * max(threads, 1)):
        send(lanes)
    while flying:
        future = _next(client, done)
        lanes = flying.pop(future)
        columns = _result(future)
        future.release()
        following = next(waiting, None)
        if following is not None:
            send(following)
        yield lanes, columns


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


def _result(future: Future) -> Any:
    try:
        return future.result(timeout=DESERTED)
    except KilledWorker as error:
        raise ClusterLostError("a chunk of lanes has killed one worker after the other") from error
    except ModuleNotFoundError as error:
        raise UserError(
            f"A worker of the cluster lacks the package {error.name}; install this version of jaxstick on "
            "all of them."
        ) from error
    except (CancelledError, TimeoutError, OSError) as error:
        raise ClusterLostError("the connection to the Dask scheduler is lost") from error


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
