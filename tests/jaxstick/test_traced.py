"""Traced programs kept between processes."""

from __future__ import annotations

import gc
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.parts.contact import LoadedContact
from jaxstick.precision import float64
from jaxstick.traced import Traced

POINT = np.array([0.3, -1.2, 2.0])


def counted() -> tuple[Callable[[LoadedContact, jax.Array], dict[str, jax.Array]], list[None]]:
    """A function, and a list that has an entry for every time that it is traced."""
    times: list[None] = []

    def function(contact: LoadedContact, point: jax.Array) -> dict[str, jax.Array]:
        times.append(None)
        return {"wave": jnp.sin(contact.k1 * point), "sum": jnp.sum(point)}

    return function, times


@pytest.fixture
def folder(tmp_path: Path):
    """A folder where jax keeps compiled programs."""
    before = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path
    jax.config.update("jax_compilation_cache_dir", before)


def kept(folder: Path) -> list[Path]:
    return sorted(folder.glob("traced-*-cache"))


def right(program: Traced, point: np.ndarray = POINT) -> bool:
    found = program(LoadedContact(3.0), point)
    return np.allclose(found["wave"], np.sin(3 * point), rtol=1e-12) and np.isclose(found["sum"], point.sum())


def test_another_process_need_not_trace_again(folder):
    (first, times), (second, more) = counted(), counted()
    program = Traced(first, {})
    assert right(program) and right(program, 2 * POINT) and len(times) == 1
    assert len(kept(folder)) == 1
    assert right(Traced(second, {})) and not more


def test_several_threads_share_one_program(folder):
    function, times = counted()
    program = Traced(function, {})

    def used(share: int) -> bool:
        with float64():
            return right(program, share * POINT)

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(used, range(1, 9)))
    assert len(times) == 1 and len(kept(folder)) == 1


def test_other_shapes_are_another_program(folder):
    program = Traced(counted()[0], {})
    assert right(program) and right(program, np.arange(5.0)) and right(program)
    assert len(kept(folder)) == 2


def test_what_cannot_be_read_is_traced_anew(folder):
    assert right(Traced(counted()[0], {}))
    (file,) = kept(folder)
    file.write_bytes(b"half of a pro")
    again, times = counted()
    assert right(Traced(again, {})) and len(times) == 1
    assert kept(folder) == [file] and len(file.read_bytes()) > 100


def test_other_code_is_another_program(folder, monkeypatch):
    assert right(Traced(counted()[0], {}))
    monkeypatch.setattr("jaxstick.traced.digest", lambda modules: "changed")
    again, times = counted()
    assert right(Traced(again, {})) and len(times) == 1
    assert len(kept(folder)) == 2


def test_nothing_is_kept_where_jax_keeps_nothing(folder):
    jax.config.update("jax_compilation_cache_dir", None)
    function, times = counted()
    program = Traced(function, {})
    assert right(program) and right(program) and len(times) == 1
    assert not kept(folder)


def test_a_folder_that_cannot_be_written_is_done_without(folder):
    jax.config.update("jax_compilation_cache_dir", str(folder / "missing"))
    assert right(Traced(counted()[0], {}))
    assert not kept(folder)


@pytest.mark.parametrize("collects", [True, False])
def test_garbage_is_looked_for_afterwards_as_before(folder, collects):
    seen = []

    def function(contact: LoadedContact, point: jax.Array) -> jax.Array:
        seen.append(gc.isenabled())
        return contact.k1 * point

    try:
        gc.enable() if collects else gc.disable()
        Traced(function, {})(LoadedContact(3.0), POINT)
        assert gc.isenabled() is collects and not any(seen)
    finally:
        gc.enable()
