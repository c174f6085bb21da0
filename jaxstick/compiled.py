"""How programs over lanes are compiled for the CPU, and run in packs on all of its cores."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array

OPTIONS = {"xla_cpu_enable_fast_math": True, "xla_cpu_prefer_vector_width": "512"}
"""Options of the XLA compiler: sums may be reassociated and contracted, infinities and NaN keep their
meaning, and vectors are as wide as the CPU has them. Other backends take no notice."""

_PLAIN_LOOPS = {"xla_cpu_use_fusion_emitters": False} if jax.__version_info__ < (0, 11) else {}
QUICKLY = {**OPTIONS, "xla_backend_optimization_level": 1, **_PLAIN_LOOPS}
"""For large programs over hundreds of lanes rather than many thousands: compiled in six tenths of the time,
and no slower. From jax 0.11 on there is one option less, for there are no other emitters."""

LANES_A_PACK = 512
"""Lanes that go through a program together: enough to hide what a step costs whatever the number of lanes,
few enough that their state stays near the core."""


WIDTH = 8
"""Float64 numbers in the widest vector of a CPU."""


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function under `equinox.filter_jit`, compiled with `OPTIONS`.

    jax takes compiler options at the outermost `jit` only: where the caller is tracing, the function becomes
    a part of the caller's program and its options are the caller's.
    """
    alone = eqx.filter_jit(function, compiler_options=OPTIONS)  # pyright: ignore[reportCallIssue]
    within = eqx.filter_jit(function)

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        return (within if _tracing(args, kwargs) else alone)(*args, **kwargs)

    return call


def compiled_for_arrays(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function under `jax.jit`, compiled with `OPTIONS`, for arguments whose leaves are all arrays and
    callers that are not tracing: a call then costs a third of what it costs `compiled`."""
    return jax.jit(function, compiler_options=OPTIONS)


def in_packs(
    program: Callable[..., Any],
    lanes: Any,
    *shared: Any,
    pack: int = LANES_A_PACK,
    workers: int | None = None,
) -> Any:
    """`program(lanes, *shared)`, the lanes taken in packs of one size, several packs at a time.

    `lanes` is a tree of arrays with a leading axis of lanes, and so is what the program returns; `program`
    should be `compiled`, and sees every pack with the same shapes, the last one filled up with its last lane.
    At most `pack` lanes go together; fewer where that shares them better among the `workers`, by default one
    thread for every core that this process may use. The result is a tree of numpy arrays.

    Raises ValueError for no lanes.
    """
    count = _count(lanes)
    device = jax.config.jax_default_device  # pyright: ignore[reportAttributeAccessIssue]
    if workers is None:
        workers = cores() if (device.platform if device else jax.default_backend()) == "cpu" else 1
    rounds = -(-count // (workers * pack))
    size = -(-count // (workers * rounds))
    doubles = bool(jax.config.read("jax_enable_x64"))

    def run(first: int) -> Any:
        last = min(first + size, count)
        with jax.enable_x64(doubles), jax.default_device(device):
            result = program(jax.tree.map(lambda leaf: _filled(leaf[first:last], size), lanes), *shared)
        return jax.tree.map(lambda leaf: np.asarray(leaf)[: last - first], result)

    with ThreadPoolExecutor(workers) as pool:
        packs = pool.map(run, range(0, count, size))
        return _gathered(packs, count)


def lane_jacobian(
    function: Callable[..., tuple[Any, Any]], points: Array, *lanes: Any, in_rows: bool | None = None
) -> tuple[Any, Any]:
    """The derivatives of `function(point, *lane)` with respect to the point, for every lane: those of the
    first of the two trees that it returns, and the second as it is. Forwards, as by
    `jax.vmap(jax.jacfwd(function, has_aux=True))`; for use inside a compiled function.

    `points` has shape (lanes, n), every array of `lanes` a leading axis of lanes; an array of shape `s` a
    lane gives (lanes, *s, n) and, as it is, (lanes, *s).

    Lanes stand `in_rows` of `WIDTH`, a row under each of the n directions: so the compiler computes what the
    directions share once for all of them, in vectors, rather than once for each. That takes two thirds of the
    time or less where the CPU has vectors as wide, and more where it has not, so it is done only there unless
    the caller says so.
    """
    if not (has_wide_vectors() if in_rows is None else in_rows):
        return jax.vmap(jax.jacfwd(function, has_aux=True))(points, *lanes)
    count, n = jnp.shape(points)
    rows = -(-count // WIDTH)
    index = np.minimum(np.arange(rows * WIDTH), count - 1)

    def as_rows(leaf: Array) -> Array:
        leaf = jnp.asarray(leaf)
        filled = leaf if len(index) == count else leaf[index]
        return filled.reshape(rows, WIDTH, *leaf.shape[1:])

    def row(points: Array, lanes: Any) -> tuple[Any, Any]:
        def every(points: Array) -> tuple[Any, Any]:
            return jax.vmap(function)(points, *lanes)

        def along(direction: Array) -> tuple[Any, Any]:
            directions = jnp.broadcast_to(direction, points.shape)
            _, slope, rest = jax.jvp(every, (points,), (directions,), has_aux=True)
            return slope, rest

        return jax.vmap(along, out_axes=(-1, None))(jnp.eye(n, dtype=points.dtype))

    def in_line(leaf: Array) -> Array:
        return leaf.reshape(rows * WIDTH, *leaf.shape[2:])[:count]

    return jax.tree.map(in_line, jax.vmap(row)(as_rows(points), jax.tree.map(as_rows, lanes)))


@functools.cache
def has_wide_vectors() -> bool:
    """Whether the CPU has vectors of `WIDTH` numbers, as Linux tells; no elsewhere."""
    try:
        return "avx512f" in Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
    except OSError:
        return False


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _tracing(args: Any, kwargs: Any) -> bool:
    leaves = jax.tree.leaves((args, kwargs))
    return any(isinstance(leaf, Tracer) for leaf in leaves) or isinstance(jnp.zeros(()), Tracer)


def _count(lanes: Any) -> int:
    counts = {np.shape(leaf)[0] for leaf in jax.tree.leaves(lanes)}
    if len(counts) != 1 or 0 in counts:
        raise ValueError(f"every array needs the same number of lanes, at least one; found {sorted(counts)}")
    return counts.pop()


def _filled(lanes: Any, size: int) -> np.ndarray:
    """The lanes and so many copies of the last one that there are `size`."""
    lanes = np.asarray(lanes)
    missing = size - len(lanes)
    return np.concatenate([lanes, np.repeat(lanes[-1:], missing, axis=0)]) if missing else lanes


def _gathered(packs: Iterator[Any], count: int) -> Any:
    """The packs one after the other in arrays made once."""
    whole: list[np.ndarray] = []
    structure = None
    first = 0
    for result in packs:
        leaves, structure = jax.tree.flatten(result)
        if not whole:
            whole = [np.empty((count, *leaf.shape[1:]), leaf.dtype) for leaf in leaves]
        for target, leaf in zip(whole, leaves, strict=True):
            target[first : first + len(leaf)] = leaf
        first += len(leaves[0])
    assert structure is not None
    return jax.tree.unflatten(structure, whole)
