"""Chunks of a sweep on the workers of a Dask cluster that is there already."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from distributed import Client, Future, KilledWorker

from jaxstick.sweeps.lost import ClusterLostError
from jaxstick.sweeps.task import compute_pickled
from jaxstick.sweeps.workers import client_of, finished, result_of
from jaxstick.version import version


@contextmanager
def connected(address: str) -> Iterator[Callable[..., Iterator[tuple[range, Any]]]]:
    """The workers of the Dask scheduler at `address`, as a function that computes ranges of lanes.

    Raises UserError where no scheduler answers there within 15 s, or it has no worker after 15 s more.
    """
    with client_of(address) as client:
        yield partial(_on_cluster, client)


def _on_cluster(
    client: Client, points: Any, pending: Sequence[range], derivatives: Sequence[str]
) -> Iterator[tuple[range, Any]]:
    """The columns of every range of lanes of `points`, in the order in which the workers finish them.

    What a worker had when it died is computed again by another; a chunk whose workers die one after another
    (as often as the scheduler allows, three times by default) ends the sweep.

    Raises UserError where a worker lacks jaxstick or runs another version; ClusterLostError where the
    scheduler goes away, a chunk kills its workers, or no worker has been left for two minutes.
    """

    def submit(lanes: range) -> Future:
        data = pickle.dumps(points[lanes.start : lanes.stop])
        return client.submit(compute_pickled, data, tuple(derivatives), version(), pure=False)

    return finished(client, pending, submit, _columns)


def _columns(future: Future) -> Any:
    try:
        return result_of(future)
    except KilledWorker as error:
        raise ClusterLostError("a chunk of lanes has killed one worker after the other") from error
