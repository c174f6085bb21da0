"""Where compiled programs are kept, and when not."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from jaxstick import compilation_cache
from jaxstick.compilation_cache import compute_on_cpu, keep_compiled

FOLDER = "JAX_COMPILATION_CACHE_DIR"


@pytest.fixture(autouse=True)
def clean(monkeypatch, tmp_path):
    """None of the variables set, and none left behind."""
    for name in (FOLDER, "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "JAXSTICK_CACHE"):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.mark.parametrize(("said", "then"), [(None, "cpu"), ("cuda", "cuda")])
def test_the_cpu_computes_unless_the_user_says_otherwise(monkeypatch, said, then):
    monkeypatch.setenv("JAX_PLATFORMS", said or "")
    if said is None:
        monkeypatch.delenv("JAX_PLATFORMS")
    compute_on_cpu()
    assert os.environ["JAX_PLATFORMS"] == then


@pytest.mark.parametrize("module", ["jaxstick", "fitting"])
def test_so_do_the_commands(module):
    """The process ends where a command would begin, and says what it would compute on."""
    code = (
        "import os, sys, click\n"
        "said = lambda *_, **__: print(os.environ.get('JAX_PLATFORMS'), 'jax' in sys.modules)\n"
        "click.Group.__call__ = said\n"
        f"from {module}.cli import main\n"
        "main()"
    )
    bare = {name: value for name, value in os.environ.items() if name != "JAX_PLATFORMS"}
    said = subprocess.run([sys.executable, "-c", code], env=bare, capture_output=True, text=True, check=True)
    assert said.stdout.split() == ["cpu", "False"]


@pytest.mark.parametrize("first", ["", "import jax\n"])
def test_set_up_whether_or_not_jax_was_imported_before(tmp_path, first):
    code = (
        f"{first}from jaxstick.compilation_cache import set_up_jax\n"
        "set_up_jax()\n"
        "import jax\n"
        "said = jax.config\n"
        "print(said.jax_platforms, said.jax_compilation_cache_dir)\n"
        "print(said.jax_persistent_cache_min_compile_time_secs)"
    )
    bare = {name: value for name, value in os.environ.items() if name != "JAX_PLATFORMS"}
    said = subprocess.run([sys.executable, "-c", code], env=bare, capture_output=True, text=True, check=True)
    assert said.stdout.split() == ["cpu", str(tmp_path / "cache" / "jaxstick"), "0.0"]


def test_a_folder_of_this_user(tmp_path):
    keep_compiled()
    assert os.environ[FOLDER] == str(tmp_path / "cache" / "jaxstick")
    assert (tmp_path / "cache" / "jaxstick").is_dir()


def test_another_folder_by_the_switch(tmp_path, monkeypatch):
    monkeypatch.setenv("JAXSTICK_CACHE", str(tmp_path / "elsewhere"))
    keep_compiled()
    assert os.environ[FOLDER] == str(tmp_path / "elsewhere")


@pytest.mark.parametrize("word", ["off", "0", "OFF"])
def test_switched_off(word, tmp_path, monkeypatch):
    monkeypatch.setenv("JAXSTICK_CACHE", word)
    keep_compiled()
    assert FOLDER not in os.environ and not (tmp_path / "cache").exists()


def test_what_the_user_chose_for_jax_stands(monkeypatch, tmp_path):
    monkeypatch.setenv(FOLDER, "chosen")
    keep_compiled()
    assert os.environ[FOLDER] == "chosen" and not (tmp_path / "cache").exists()


def test_a_folder_that_cannot_be_made_is_done_without(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    keep_compiled()
    assert FOLDER not in os.environ


def test_the_oldest_programs_go_first(monkeypatch, tmp_path):
    folder = tmp_path / "cache" / "jaxstick"
    folder.mkdir(parents=True)
    for age, name in enumerate(("new", "old", "oldest")):
        path = folder / f"{name}-cache"
        path.write_bytes(bytes(100))
        os.utime(path, (1e9 - age, 1e9 - age))
    (folder / "notes").write_bytes(bytes(1000))
    monkeypatch.setattr(compilation_cache, "LARGEST", 250)
    keep_compiled()
    assert sorted(path.name for path in folder.iterdir()) == ["new-cache", "notes", "old-cache"]
