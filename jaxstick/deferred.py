"""Functions that are imported when they are first called, so that commands start at once."""

import importlib
from collections.abc import Callable
from typing import Any


def deferred(module: str, name: str) -> Callable[..., Any]:
    """The function `name` of `module`, which is imported at the first call and not before.

    Stands at the top of a file where an import of something slow (jax, matplotlib) would stand, both
    arguments written out: `fit = deferred("fitting.fit", "fit")` counts as an import of fitting.fit.
    """

    def call(*args: Any, **kwargs: Any) -> Any:
        return getattr(importlib.import_module(module), name)(*args, **kwargs)

    call.__name__ = call.__qualname__ = name
    return call
