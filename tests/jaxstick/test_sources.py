"""What code a module is made of."""

from __future__ import annotations

import importlib
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from jaxstick import sources
from jaxstick.simulate import simulate


@pytest.fixture
def package(tmp_path: Path, monkeypatch):
    """A package in which `top` imports `middle`, that one, in a function, `deep`, and nothing `aside`."""
    folder = tmp_path / "layered"
    folder.mkdir()
    for name, text in {
        "__init__": "",
        "top": "from layered.middle import half\n",
        "middle": "def half():\n    from layered import deep\n    return deep.VALUE\n",
        "deep": "import json\nVALUE = 1\n",
        "aside": "VALUE = 2\n",
    }.items():
        (folder / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("top", "middle", "deep", "aside"):
        importlib.import_module(f"layered.{name}")
    yield folder
    for name in [name for name in sys.modules if name.partition(".")[0] == "layered"]:
        del sys.modules[name]
    _forget()


def _forget() -> None:
    """What a new process would not know."""
    sources._imported.cache_clear()
    sources._source_digest.cache_clear()


def changed(package: Path, name: str) -> bool:
    """Whether the digest of `top` changes with a line more in another module."""
    _forget()
    before = sources.digest(["layered.top"])
    file = package / f"{name}.py"
    file.write_text(file.read_text() + "MORE = 3\n")
    _forget()
    return sources.digest(["layered.top"]) != before


@pytest.mark.parametrize("name", ["top", "middle", "deep"])
def test_what_is_imported_counts_however_far_down(package, name):
    assert changed(package, name)


def test_what_is_not_imported_does_not_count(package):
    assert not changed(package, "aside")


def test_modules_without_a_source_are_left_out():
    assert sources.digest(["builtins"]) == sources.digest([])
    assert sources.digest(["builtins", "json"]) != sources.digest([])


def test_several_threads_may_ask_at_once():
    """Python's own parser may not be asked so."""

    def asked(_: int) -> str:
        _forget()
        return sources.digest([simulate.__module__])

    with ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(asked, range(48)))) == 1
