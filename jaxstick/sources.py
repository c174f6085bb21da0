"""What code a module is made of: its own source and those of all modules that it imports from the same
packages, as far as reading the sources tells."""

from __future__ import annotations

import ast
import functools
import hashlib
import sys
import threading
from collections.abc import Iterable
from pathlib import Path

_PARSING = threading.Lock()
"""Python's parser, as of 3.11, fails now and then where two threads use it at a time."""


def digest(modules: Iterable[str]) -> str:
    """A digest of the sources that these modules, which have been imported, are made of.

    Followed are the imports from the modules' own packages, wherever they stand in a source; not a module
    that is imported by a name put together at run time.
    """
    found, new = set[str](), {name for name in modules if _file(name) is not None}
    packages = frozenset(name.partition(".")[0] for name in new)
    while new:
        found |= new
        new = {other for name in new for other in _imported(name, packages)} - found
    total = hashlib.sha256()
    for name in sorted(found):
        total.update(f"{name} {_source_digest(name)}\n".encode())
    return total.hexdigest()


@functools.cache
def _imported(module: str, packages: frozenset[str]) -> tuple[str, ...]:
    """The modules of these packages that a module imports, or imports something from."""
    file = _file(module)
    assert file is not None
    names = set[str]()
    with _PARSING:
        tree = ast.parse(file.read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module is not None and not node.level:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    own = (name for name in names if name.partition(".")[0] in packages)
    return tuple(name for name in own if _file(name) is not None)


@functools.cache
def _source_digest(module: str) -> str:
    file = _file(module)
    assert file is not None
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _file(module: str) -> Path | None:
    """The source file of a module that has been imported, if it has one."""
    file = getattr(sys.modules.get(module), "__file__", None)
    return Path(file) if file is not None and file.endswith(".py") else None
