"""Traced programs kept between processes.

Tracing a large program in Python takes seconds, every time that a process first runs it; what it comes to, a
text for the compiler, does not change until the code does. It is kept beside jax's compiled programs.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import sys
import threading
from collections import defaultdict
from collections.abc import Callable, Hashable, Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from jaxstick.errors import UserError
from jaxstick.output import atomic_write_bytes

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
        self._programs: dict[Hashable, Callable[..., Any]] = {}
        self._locks: defaultdict[Hashable, threading.Lock] = defaultdict(threading.Lock)

    def __call__(self, *args: Any) -> Any:
        leaves, structure = jax.tree.flatten(args)
        leaves = [np.asarray(leaf) for leaf in leaves]
        shapes = tuple((leaf.shape, leaf.dtype.str) for leaf in leaves)
        key = (structure, shapes)
        if key not in self._programs:
            with self._locks[key]:
                if key not in self._programs:
                    self._programs[key] = self._program(leaves, structure, shapes)
        return self._programs[key](*leaves)

    def _program(self, leaves: list[np.ndarray], structure: Any, shapes: Hashable) -> Callable[..., Any]:
        def flat(*leaves: Any) -> Any:
            return self._function(*jax.tree.unflatten(structure, leaves))

        folder = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
        if folder is None:
            return jax.jit(flat, compiler_options=self._options)
        written = f"{jax.__version__} {jax.default_backend()} {self._code()} {structure} {shapes}"
        file = Path(folder) / NAME.format(hashlib.sha256(written.encode()).hexdigest())
        exported = _read(file)
        if exported is None:
            exported = jax.export.export(jax.jit(flat))(
                *(jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in leaves)
            )
            _write(file, bytes(exported.serialize()))
        return jax.jit(exported.call, compiler_options=self._options)

    def _code(self) -> str:
        """A digest of everything that the function may be made of: its package and this one."""
        packages = {__name__.partition(".")[0], self._function.__module__.partition(".")[0]}
        name = f"{self._function.__module__}.{self._function.__qualname__}"
        return " ".join([name, *(_digest(package) for package in sorted(packages))])


def traced(options: Mapping[str, Any]) -> Callable[[Callable[..., Any]], Traced]:
    """Makes a function a `Traced` one, compiled with these options."""
    return lambda function: Traced(function, options)


@functools.cache
def _digest(package: str) -> str:
    """A digest of the sources of a package that has been imported."""
    digest = hashlib.sha256()
    file = sys.modules[package].__file__
    assert file is not None
    top = Path(file).parent
    for path in sorted(top.rglob("*.py")):
        digest.update(f"{path.relative_to(top)}\n".encode() + path.read_bytes())
    return digest.hexdigest()


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
