"""Finds the effects on the shelf by listing its folder."""

from __future__ import annotations

import functools
import importlib
import inspect
import pkgutil
from types import ModuleType

from jaxstick import effects
from jaxstick.effect import AbstractEffect


@functools.cache
def catalogue() -> dict[str, type[AbstractEffect]]:
    """Every effect on the shelf under its key, the name of its file.

    Raises TypeError for a file that does not define exactly one effect.
    """
    names = sorted(entry.name for entry in pkgutil.iter_modules(effects.__path__))
    return {name: _only_effect(importlib.import_module(f"{effects.__name__}.{name}")) for name in names}


def _only_effect(module: ModuleType) -> type[AbstractEffect]:
    found = [
        member
        for _, member in inspect.getmembers(module, inspect.isclass)
        if issubclass(member, AbstractEffect) and member.__module__ == module.__name__
    ]
    if len(found) != 1:
        raise TypeError(f"{module.__name__} must define exactly one effect, found {len(found)}")
    return found[0]
