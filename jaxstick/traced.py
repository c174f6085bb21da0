"""Traced programs kept between processes.

Tracing a large program in Python takes seconds, every time that a process first runs it; what it comes to, a
text for the compiler, does not change until the code does. It is kept beside jax's compiled programs.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import hashlib
import os
import threading
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

from jaxstick.errors import UserError
from jaxstick.output import atomic_write_bytes
from jaxstick.sources import digest

_TRACING = threading.Lock()
"""Tracing is Python, one thread's work at a time; another's program compiles beside it."""

Program = Callable[..., Any]
"""A compiled program, called with arrays."""

NAME = "traced-{}-cache"
"""What a kept program's file is called; files that end like this are thrown away when they are the oldest."""


class Traced:
    """A function of trees of numpy arrays under `jax.jit`, traced at most once for every code, structure and
    shapes where jax keeps compiled programs, and once in every process where it does not.

    The function's module and name stand for what it does, so it must not depend on anything else than its
    arguments. A file that cannot be read is no program; one that cannot be written is done without.
    """

    def __init__(self, function: Callable[..., Any], options: Mapping[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self._function, self._options = function, dict(options)
        self._programs: dict[Hashable, Program] = {}
        self._locks: dict[Hashable, threading.Lock] = {}

    def __call__(self, *args: Any) -> Any:
        return self.program(*args)(*(np.asarray(leaf) for leaf in jax.tree.leaves(args)))

    def program(self, *args: Any) -> Program:
        """The program for arguments of the structure and shapes of these, called with their arrays, leaf by
        leaf: for a caller who has them at hand, and calls it often."""
        leaves, structure = jax.tree.flatten(args)
        leaves = [np.asarray(leaf) for leaf in leaves]
        shapes = tuple((leaf.shape, leaf.dtype.str) for leaf in leaves)
        key = (structure, shapes)
        if key not in self._programs:
            with self._locks.setdefault(key, threading.Lock()):
                if key not in self._programs:
                    self._programs[key] = self._traced(leaves, structure, shapes)
        return self._programs[key]

    def _traced(self, leaves: list[np.ndarray], structure: Any, shapes: Hashable) -> Program:
        def flat(*leaves: Any) -> Any:
            return self._function(*jax.tree.unflatten(structure, leaves))

        shaped = [jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in leaves]
        folder = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
        with _TRACING, _uncollected():
            if folder is None:
                program = flat
            else:
                doubles = jax.config.read("jax_enable_x64")
                where = f"{jax.__version__} {jax.default_backend()} {doubles}"
                written = f"{where} {self._code(structure)} {structure} {shapes}"
                file = Path(folder) / NAME.format(hashlib.sha256(written.encode()).hexdigest())
                program = _kept(file, flat, shaped).call
            lowered = jax.jit(program).lower(*shaped)
        return lowered.compile(self._options)

    def _code(self, structure: Any) -> str:
        """The function's name, and a digest of all code that it may be made of: that of its module, and of
        the classes among its arguments."""
        name = f"{self._function.__module__}.{self._function.__qualname__}"
        return f"{name} {digest({self._function.__module__, *_modules(structure)})}"


@contextlib.contextmanager
def _uncollected() -> Iterator[None]:
    """Python looks for no garbage meanwhile: tracing makes very many objects that stay, among which that
    takes a quarter of the time."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def traced(options: Mapping[str, Any]) -> Callable[[Callable[..., Any]], Traced]:
    """Makes a function a `Traced` one, compiled with these options."""
    return lambda function: Traced(function, options)


def _modules(structure: Any) -> set[str]:
    """The modules that define the classes in the structure of a tree."""
    node = structure.node_data()
    here = set() if node is None else {node[0].__module__}
    return here.union(*(_modules(child) for child in structure.children()))


def _kept(
    file: Path, function: Callable[..., Any], shaped: Sequence[jax.ShapeDtypeStruct]
) -> jax.export.Exported:
    """The function traced, read from the file, or else written there."""
    exported = _read(file)
    if exported is None:
        exported = jax.export.export(jax.jit(function))(*shaped)
        _write(file, bytes(exported.serialize()))
    return exported


def _read(file: Path) -> jax.export.Exported | None:
    try:
        content = file.read_bytes()
        os.utime(file)
        return jax.export.deserialize(bytearray(content))
    except Exception:
        return None


def _write(file: Path, content: bytes) -> None:
    with contextlib.suppress(UserError):
        atomic_write_bytes(file, content)
