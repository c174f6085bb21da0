"""Functions that are imported when they are first called, so that commands start at once."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable
from typing import Any


@dataclasses.dataclass(frozen=True)
class Deferred:
    """The function `name` of `module`, which is imported at the first call, or by `load`."""

    module: str
    name: str

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self.load()(*args, **kwargs)

    def load(self) -> Callable[..., Any]:
        """The function itself."""
        return getattr(importlib.import_module(self.module), self.name)


def deferred(module: str, name: str) -> Deferred:
    """The function `name` of `module`, which is imported at the first call and not before.

    Stands at the top of a file where an import of something slow (jax, matplotlib) would stand, both
    arguments written out: `fit = deferred("fitting.fit", "fit")` counts as an import of fitting.fit.
    """
    return Deferred(module, name)
