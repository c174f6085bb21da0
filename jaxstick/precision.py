"""Double precision for the public entry points, whatever the user's own setting is."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any, ParamSpec, TypeVar, overload

import jax
import jax.numpy as jnp
import numpy as np

from jaxstick.enclosure import enclosed

P = ParamSpec("P")
R = TypeVar("R")


@overload
def float64() -> AbstractContextManager[None]: ...
@overload
def float64(function: Callable[P, R]) -> Callable[P, R]: ...
def float64(function: Callable[..., Any] | None = None) -> Any:
    """Float64 for the length of a `with` block or of a call; jax's global setting is not touched.

    `with float64():` holds for the block, in the current thread. `@float64` holds for every call of the
    function: arrays of lower precision among its arguments are widened and its results are float64, also
    under the caller's `jit`, `vmap`, `grad` and `jacfwd` in a session of float32.

    What jax itself does at the rim of such a session remains: a gradient has the type of what it is taken
    with respect to, so it is computed in float64 and rounded to float32 at the end. With
    `with float64():` around the transformation every digit is kept, and nothing is computed twice.
    """
    if function is None:
        return jax.enable_x64(True)

    @functools.wraps(function)
    def in_float64(*args: Any, **kwargs: Any) -> Any:
        if jax.config.read("jax_enable_x64"):
            args, kwargs = jax.tree.map(widened, (args, kwargs))
            return function(*args, **kwargs)
        with jax.enable_x64(True):
            args, kwargs = jax.tree.map(widened, (args, kwargs))
            return enclosed(function, args, kwargs)

    return in_float64


def widened(leaf: Any) -> Any:
    """An array of lower precision as float64 or complex128; anything else as it is."""
    if not isinstance(leaf, (jax.Array, np.ndarray, np.generic)):
        return leaf
    if jnp.issubdtype(leaf.dtype, jnp.complexfloating):
        return leaf.astype(np.complex128)
    return leaf.astype(np.float64) if jnp.issubdtype(leaf.dtype, jnp.floating) else leaf
