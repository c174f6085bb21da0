"""Computes the chunks of a sweep, here or on a Dask cluster, and keeps each as soon as it is finished."""

import importlib.util
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.sweeps.plan import Plan
from jaxstick.sweeps.store import Store

compute = deferred("jaxstick.sweep", "compute")
connected = deferred("jaxstick.sweeps.cluster", "connected")

CHUNK = 4096
"""Lanes computed at once."""

Evaluate = Callable[[Any, Sequence[range], Sequence[str]], Iterator[tuple[range, Any]]]
"""From all points, the ranges of lanes to compute and the derivatives wanted to the columns of each range."""


@contextmanager
def computing(scheduler: str | None = None) -> Iterator[Evaluate]:
    """What computes: this process, or the workers of the Dask scheduler at an address.

    Raises UserError for a scheduler that cannot be used; see `jaxstick.sweeps.cluster.connected`.
    """
    if scheduler is None:
        yield _here
        return
    if importlib.util.find_spec("distributed") is None:
        raise UserError(
            "--scheduler needs the package distributed, which is not installed here: pip install "
            "'jaxstick[cluster]'."
        )
    with connected(scheduler) as on_cluster:
        yield on_cluster


def finish(
    plan: Plan,
    store: Store,
    evaluate: Evaluate,
    chunk: int = CHUNK,
    told: Callable[[int], None] = lambda lanes: None,
) -> None:
    """Computes the lanes that the store lacks, `chunk` at a time, and keeps them there.

    `told` is called with the number of lanes whenever a chunk is kept.
    """
    pending = store.pending(chunk)
    if not pending:
        return
    for lanes, columns in evaluate(plan.points(), pending, plan.derivatives):
        store.keep(lanes, columns)
        told(len(lanes))
    if store.pending(chunk):
        raise RuntimeError(f"only {store.finished} of {plan.lanes} lanes came back")


def _here(points: Any, pending: Sequence[range], derivatives: Sequence[str]) -> Iterator[tuple[range, Any]]:
    for lanes in pending:
        yield lanes, compute(points[lanes.start : lanes.stop], derivatives=derivatives)
