"""Chunks of a sweep: whole or not there, computed once, read back to the last bit."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from jaxstick.errors import UserError
from jaxstick.output import OutputFolder
from jaxstick.sweeps import engine
from jaxstick.sweeps.store import Store
from jaxstick.sweeps.tables import write_tables
from jaxstick.sweeps.task import compute_pickled

ROOT = Path(__file__).resolve().parents[2]


def columns(lanes: range) -> dict[str, np.ndarray]:
    number = np.arange(lanes.start, lanes.stop)
    return {"number": number, "root": np.sqrt(number), "wide": np.outer(number, [1.0, np.nan])}


def opened(folder: Path, **options) -> Store:
    folder.mkdir(exist_ok=True)
    return Store(folder, **({"fingerprint": "a", "lanes": 10} | options))


def test_what_is_kept_comes_back_in_order(tmp_path):
    store = opened(tmp_path)
    assert store.pending(4) == [range(4), range(4, 8), range(8, 10)]
    store.keep(range(4, 8), columns(range(4, 8)))
    assert store.pending(3) == [range(3), range(3, 4), range(8, 10)]
    for lanes in store.pending(4):
        store.keep(lanes, columns(lanes))
    again = opened(tmp_path)
    assert again.finished == 10 and again.pending(4) == []
    together = {name: np.concatenate(parts) for name, parts in _columns(again).items()}
    for name, column in columns(range(10)).items():
        np.testing.assert_array_equal(together[name], column)


def _columns(store: Store) -> dict[str, list[np.ndarray]]:
    parts: dict[str, list[np.ndarray]] = {}
    for chunk in store.chunks():
        for name, column in chunk.items():
            parts.setdefault(name, []).append(column)
    return parts


@pytest.mark.parametrize("harm", ["shorter", "one bit", "empty", "no checksum"])
def test_a_broken_chunk_counts_as_not_there(tmp_path, harm):
    store = opened(tmp_path)
    for lanes in store.pending(5):
        store.keep(lanes, columns(lanes))
    path = tmp_path / "lanes-00000005-00000010.chunk"
    data = path.read_bytes()
    flipped = data[:200] + bytes([data[200] ^ 1]) + data[201:]
    bare = data.partition(b"\n")[2]
    path.write_bytes({"shorter": data[:-1], "one bit": flipped, "empty": b"", "no checksum": bare}[harm])
    with pytest.raises(UserError, match=r"lanes-00000005-00000010.chunk: this file was changed"):
        list(store.chunks())
    again = opened(tmp_path)
    assert again.pending(5) == [range(5, 10)]
    assert not path.exists()


def test_files_of_another_kind_are_left_alone_and_not_read(tmp_path):
    (tmp_path / ".lanes-00000000-00000005.chunk.jaxstick-part-0123").write_bytes(b"half")
    (tmp_path / "lanes-00000000-00000099.chunk").write_bytes(b"beyond the last lane")
    with pytest.raises(UserError, match="other settings"):
        opened(tmp_path)
    (tmp_path / "lanes-00000000-00000099.chunk").unlink()
    assert opened(tmp_path).pending(10) == [range(10)]


def test_another_sweep_is_not_taken_up(tmp_path):
    opened(tmp_path).keep(range(5), columns(range(5)))
    with pytest.raises(UserError, match="an unfinished sweep with other settings is kept here"):
        opened(tmp_path, fingerprint="b")
    assert opened(tmp_path).finished == 5
    assert opened(tmp_path, fingerprint="b", overwrite=True).finished == 0
    assert opened(tmp_path, fingerprint="b").finished == 0


def test_a_chunk_has_an_entry_a_lane(tmp_path):
    with pytest.raises(ValueError, match="4 entries of number for 5 lanes"):
        opened(tmp_path).keep(range(5), columns(range(4)))


class Plan:
    """Stands in for a plan whose lanes are their numbers."""

    lanes = 10
    derivatives = ()

    def points(self):
        return np.arange(10)


def test_the_engine_computes_only_what_is_missing(tmp_path, monkeypatch):
    asked: list[list[int]] = []

    def compute(numbers, *, derivatives):
        if asked and len(asked) == 2:
            raise KeyboardInterrupt
        asked.append(numbers.tolist())
        return columns(range(numbers[0], numbers[-1] + 1))

    monkeypatch.setattr(engine, "compute", compute)
    told: list[int] = []
    plan: Any = Plan()
    with pytest.raises(KeyboardInterrupt), engine.computing() as evaluate:
        engine.finish(plan, opened(tmp_path), evaluate, 4, told.append)
    assert told == [4, 4]
    asked.append([])
    with engine.computing() as evaluate:
        engine.finish(plan, opened(tmp_path), evaluate, 4, told.append)
    assert asked == [[0, 1, 2, 3], [4, 5, 6, 7], [], [8, 9]]
    assert told == [4, 4, 2]


def test_lanes_that_do_not_come_back_are_a_failure(tmp_path):
    def forgetful(points, pending, derivatives):
        yield pending[0], columns(pending[0])

    plan: Any = Plan()
    with pytest.raises(RuntimeError, match="only 4 of 10 lanes came back"):
        engine.finish(plan, opened(tmp_path), forgetful, 4)


def test_a_worker_of_another_version_refuses():
    with pytest.raises(UserError, match=r"a worker of the cluster runs jaxstick .*, and this is 0\.0\.0"):
        compute_pickled(b"", (), "0.0.0")


def test_tables_are_json_and_csv_of_the_same_numbers(tmp_path):
    def records(chunk):
        return [
            {"number": int(n), "root": float(r), "wide": [float(w[0]), None]}
            for n, r, w, _ in zip(*chunk.values(), strict=True)
        ]

    chunks = [columns(lanes) | {"period": np.array(lanes) - 1} for lanes in (range(3), range(3, 5))]
    with (tmp_path / "a.json").open("w") as a, (tmp_path / "a.csv").open("w") as b:
        write_tables(a, b, {"schema": 1, "list": [1, float("nan")]}, chunks, records)
    read = json.loads((tmp_path / "a.json").read_text())
    assert read["schema"] == 1 and read["list"] == [1, None]
    assert [lane["root"] for lane in read["lanes"]] == np.sqrt(np.arange(5)).tolist()
    assert read["lanes"][2]["wide"] == [2.0, None]
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert lines[0] == "number,root,wide_1,wide_2,period"
    assert lines[2] == "1,1,1,," and lines[3] == f"2,{2**0.5!r},2,,1" and len(lines) == 6


def test_a_killed_resumable_folder_keeps_what_it_has_and_litters_nothing(tmp_path):
    """One process is killed in the middle of writing its result; the next finds what was kept."""
    program = """
import os, signal, sys
from pathlib import Path
from typing import Any
from jaxstick.output import OutputFolder
with OutputFolder(Path(sys.argv[1]), resumable=True) as output:
    (output.kept / "finished").write_text("yes")
    output.write_text("result", "half")
    os.kill(os.getpid(), signal.SIGKILL)
"""
    out = tmp_path / "out"
    end = subprocess.run([sys.executable, "-c", program, out], cwd=ROOT)
    assert end.returncode == -9
    assert not out.exists()
    with pytest.raises(ZeroDivisionError), OutputFolder(out, resumable=True) as output:
        assert (output.kept / "finished").read_text() == "yes"
        assert not list(output.folder.iterdir())
        with (
            pytest.raises(UserError, match="out: another jaxstick is at work on this folder"),
            OutputFolder(out, resumable=True),
        ):
            raise AssertionError("two at a time were let in")
        raise ZeroDivisionError
    with OutputFolder(out, resumable=True) as output:
        assert (output.kept / "finished").exists()
        output.write_text("result", "whole")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert (out / "result").read_text() == "whole"
    with pytest.raises(UserError, match="holds results already"), OutputFolder(out, resumable=True):
        raise AssertionError("the old result would be replaced")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_resumable_folder_that_kept_nothing_leaves_nothing(tmp_path):
    with pytest.raises(ZeroDivisionError), OutputFolder(tmp_path / "out", resumable=True):
        raise ZeroDivisionError
    assert not list(tmp_path.iterdir())


def test_only_a_resumable_folder_keeps_anything(tmp_path):
    with OutputFolder(tmp_path / "out") as output, pytest.raises(RuntimeError, match="resumable"):
        assert output.kept
