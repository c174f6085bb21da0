"""Results folders: nothing of the user's is ever lost, nothing half-written is ever left."""

import json
import math
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from jaxstick.errors import UserError
from jaxstick.output import (
    MARKER,
    OutputFolder,
    atomic_write_bytes,
    atomic_write_text,
    atomic_writer,
    to_json,
)

ROOT = Path(__file__).resolve().parents[2]


def tree(folder: Path) -> dict[str, bytes]:
    """Every file of a folder with its bytes."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def fill(path: Path, text: str = "first", overwrite: bool = False, name: str = "fit.json") -> None:
    with OutputFolder(path, overwrite) as output:
        output.write_text(name, text)
        output.write_json("plots/data.json", {"n": 1})


def refusal(path: Path, **options) -> str:
    before = tree(path.parent)
    with pytest.raises(UserError) as caught, OutputFolder(path, **options):
        raise AssertionError("the folder was accepted")
    assert tree(path.parent) == before
    return str(caught.value)


def test_a_missing_folder_is_made_with_its_parents(tmp_path):
    fill(tmp_path / "a" / "b")
    assert sorted(tree(tmp_path)) == ["a/b/.jaxstick", "a/b/fit.json", "a/b/plots/data.json"]


def test_an_empty_folder_is_filled_and_stays_the_same_folder(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    inode = folder.stat().st_ino
    fill(folder)
    assert sorted(tree(tmp_path)) == ["out/.jaxstick", "out/fit.json", "out/plots/data.json"]
    assert folder.stat().st_ino == inode


def test_the_current_folder_may_be_meant(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fill(Path("."))
    assert Path("fit.json").read_text() == "first"


def test_our_folder_is_replaced_only_with_overwrite(tmp_path):
    folder = tmp_path / "out"
    fill(folder)
    assert "--overwrite" in refusal(folder)
    fill(folder, "second", overwrite=True, name="diagnosis.json")
    assert sorted(tree(tmp_path)) == ["out/.jaxstick", "out/diagnosis.json", "out/plots/data.json"]
    assert (folder / "diagnosis.json").read_text() == "second"


def test_a_folder_of_the_user_is_never_touched(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "thesis.txt").write_text("mine")
    for overwrite in (False, True):
        assert "not written by jaxstick" in refusal(folder, overwrite=overwrite)
    (folder / MARKER).write_text("not ours")
    assert "not written by jaxstick" in refusal(folder, overwrite=True)


def test_an_empty_folder_inside_is_the_users_too(tmp_path):
    (tmp_path / "out" / "plans").mkdir(parents=True)
    assert "not empty" in refusal(tmp_path / "out", overwrite=True)


@pytest.mark.parametrize("name", ["notes.txt", "plots/notes.txt", ".hidden"])
def test_a_file_the_user_added_stops_overwriting(tmp_path, name):
    folder = tmp_path / "out"
    fill(folder)
    (folder / name).write_text("mine")
    assert f"'{name}' was not written by jaxstick" in refusal(folder, overwrite=True)


def test_a_link_the_user_added_stops_overwriting(tmp_path):
    folder = tmp_path / "out"
    fill(folder)
    (folder / "elsewhere").symlink_to(tmp_path)
    assert "'elsewhere'" in refusal(folder, overwrite=True)


def test_a_file_the_user_changed_stops_overwriting(tmp_path):
    folder = tmp_path / "out"
    fill(folder)
    (folder / "fit.json").write_text("corrected by hand")
    assert "'fit.json' was changed" in refusal(folder, overwrite=True)


def test_files_the_user_removed_and_a_file_managers_litter_do_not_matter(tmp_path):
    folder = tmp_path / "out"
    fill(folder)
    (folder / "fit.json").unlink()
    (folder / ".DS_Store").write_bytes(b"\1")
    fill(folder, "second", overwrite=True)
    assert (folder / "fit.json").read_text() == "second"


def test_a_file_is_no_results_folder(tmp_path):
    (tmp_path / "out").write_text("mine")
    assert "this is a file" in refusal(tmp_path / "out", overwrite=True)
    assert "cannot be written" in refusal(tmp_path / "out" / "deeper")


def test_the_data_set_is_never_replaced(tmp_path):
    """Not even a simulated one, which we wrote ourselves."""
    folder = tmp_path / "data"
    fill(folder)
    for source in (folder, folder / "fit.json"):
        assert "is read for them" in refusal(folder, overwrite=True, inputs=[source])
    (tmp_path / "link").symlink_to(folder)
    with pytest.raises(UserError, match="is read for them"), OutputFolder(tmp_path / "link", True, [folder]):
        pass
    fill(folder / "results")
    assert (folder / "results" / "fit.json").exists()


def test_an_error_leaves_the_old_result(tmp_path):
    folder = tmp_path / "out"
    fill(folder)
    before = tree(tmp_path)
    with pytest.raises(ZeroDivisionError), OutputFolder(folder, True) as output:
        output.write_text("fit.json", "half")
        raise ZeroDivisionError
    assert tree(tmp_path) == before
    assert list(tmp_path.iterdir()) == [folder]


def test_a_full_disk_is_said(tmp_path, monkeypatch):
    def refuse(path: Path, *arguments, **options):
        raise OSError(28, "No space left on device", str(path))

    with (
        pytest.raises(UserError, match=r"fit\.json: this cannot be written \(No space left on device\)"),
        OutputFolder(tmp_path / "out") as output,
    ):
        monkeypatch.setattr(Path, "write_text", refuse)
        output.write_text("fit.json", "x")
    assert list(tmp_path.iterdir()) == []


def test_a_result_that_finds_its_place_taken_is_kept_beside(tmp_path):
    folder = tmp_path / "out"
    with pytest.raises(UserError, match="the new results lie in") as caught, OutputFolder(folder) as output:
        output.write_text("fit.json", "precious")
        folder.mkdir()
        (folder / "thesis.txt").write_text("mine")
    assert tree(folder) == {"thesis.txt": b"mine"}
    kept = Path(str(caught.value).split("lie in ")[1].rstrip("."))
    assert (kept / "fit.json").read_text() == "precious"


KILLED = """
import os, sys
from pathlib import Path
from jaxstick import output

steps = int(sys.argv[2])
for name in ("rename", "replace", "unlink", "rmdir", "mkdir"):
    def step(path, *arguments, ordinary=getattr(Path, name), **options):
        global steps
        steps -= 1
        if steps < 0:
            os._exit(9)
        return ordinary(path, *arguments, **options)
    setattr(Path, name, step)
with output.OutputFolder(Path(sys.argv[1]), True) as folder:
    folder.write_text("fit.json", "second")
"""


def test_a_killed_run_leaves_the_old_result_or_the_new_one(tmp_path):
    """The process dies before its first, second, ... change to the disk."""
    seen = set()
    for steps in range(12):
        folder = tmp_path / str(steps) / "out"
        fill(folder)
        before = tree(folder)
        end = subprocess.run([sys.executable, "-c", KILLED, str(folder), str(steps)], cwd=ROOT, check=False)
        with pytest.raises(UserError, match="--overwrite"), OutputFolder(folder):
            pass
        after = tree(folder)
        assert after == before or after["fit.json"] == b"second"
        seen.add((end.returncode, after == before))
        if end.returncode == 0:
            break
    assert seen == {(9, True), (0, False)}


def test_a_folder_that_may_not_be_written(tmp_path, monkeypatch):
    def refuse(path: Path, *arguments, **options):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "mkdir", refuse)
    assert "cannot be written (Permission denied)" in refusal(tmp_path / "out")


def test_permissions_are_those_of_any_new_file(tmp_path):
    (tmp_path / "plain").mkdir()
    (tmp_path / "plain" / "file").write_text("")
    fill(tmp_path / "out")
    atomic_write_text(tmp_path / "single", "x")
    assert (tmp_path / "out").stat().st_mode == (tmp_path / "plain").stat().st_mode
    for path in (tmp_path / "out" / "fit.json", tmp_path / "single"):
        assert path.stat().st_mode == (tmp_path / "plain" / "file").stat().st_mode


def test_a_single_file_is_replaced_in_one_step(tmp_path):
    path = tmp_path / "a.txt"
    atomic_write_text(path, "old\n")
    with pytest.raises(ZeroDivisionError), atomic_writer(path) as stream:
        stream.write("half")
        assert path.read_bytes() == b"old\n"
        raise ZeroDivisionError
    assert tree(tmp_path) == {"a.txt": b"old\n"}
    atomic_write_bytes(path, b"\0new")
    assert tree(tmp_path) == {"a.txt": b"\0new"}
    with pytest.raises(UserError, match="cannot be written"):
        atomic_write_text(tmp_path / "nowhere" / "a.txt", "x")


@dataclass
class Point:
    x: float
    y: tuple[int, ...]


def test_json_takes_what_numpy_gives():
    value = {
        "scalar": np.float64(0.1),
        "count": np.int32(3),
        "flag": np.bool_(True),
        "array": np.array([[1.0, math.nan], [math.inf, -0.5]]),
        "single": np.float32(0.5),
        "point": Point(math.nan, (1, 2)),
        "path": Path("a/b"),
        3: None,
        "word": "\u00b5m",
    }
    assert json.loads(to_json(value)) == {
        "scalar": 0.1,
        "count": 3,
        "flag": True,
        "array": [[1.0, None], [None, -0.5]],
        "single": 0.5,
        "point": {"x": None, "y": [1, 2]},
        "path": "a/b",
        "3": None,
        "word": "\u00b5m",
    }
    assert "NaN" not in to_json(value) and to_json(value).endswith("}\n")


def test_json_loses_no_digit():
    values = np.random.default_rng(0).normal(size=100) * 10.0 ** np.arange(-50, 50)
    assert json.loads(to_json(values)) == values.tolist()


@pytest.mark.parametrize("value", [1j, np.array([1j]), object(), {"a": {1: b"x"}}])
def test_json_refuses_what_it_cannot_hold(value):
    with pytest.raises(TypeError, match="has no place in JSON"):
        to_json(value)
