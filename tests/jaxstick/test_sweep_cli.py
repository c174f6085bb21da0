"""jaxstick sweep: what it refuses, what it writes, and that a kill costs nothing."""

from __future__ import annotations

import csv
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from jaxstick import cli
from jaxstick.sweeps import engine
from tests.jaxstick import rig_text
from tests.jaxstick.test_output import tree

ROOT = Path(__file__).resolve().parents[2]

RIG = 'name = "rig of 1987"\n' + rig_text.RIG
RUN = "[[run]]\nfrequency_hz = 1.5\nbase_amplitude_mm = 10.325\n"
RATIOS = "0.35:0.9:12"


def written(path: Path, text: str = RIG + RUN) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def rig(tmp_path) -> Path:
    return written(tmp_path / "rig.toml")


def sweep(*args: object) -> Result:
    return CliRunner().invoke(cli.jaxstick, ["sweep", *map(str, args)])


def refusal(tmp_path: Path, *args: object) -> str:
    """The one sentence with which a sweep ends with 2, having written nothing."""
    before = tree(tmp_path)
    result = sweep(*args)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1 and result.stderr.startswith("jaxstick: "), result.stderr
    assert result.stderr.rstrip().endswith((".", "?"))
    assert tree(tmp_path) == before
    return result.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--ratios", "0.04:1.0"], "'0.04:1.0' has the range '0.04:1.0', which is not low:high:count"),
        (["--ratios", "0.1,x"], "'0.1,x' has 'x', which is not a finite number"),
        (["--ratios", ""], "which is not a finite number"),
        (["--ratios", "0.1:1:0"], "a whole number from 1 on"),
        (["--ratios", "0.1:1:1e12"], "more than 10000000 values"),
        (["--ratios", "0,0.5"], "frequency ratio must be greater than 0; 0 is given"),
        (["--ratios", "-0.5:0.5:3"], "frequency ratio must be greater than 0; -0.5 is given"),
        (["--ratios", "0.1", "--amplitudes-mm", "0"], "base amplitude must be greater than 0; 0 mm is given"),
        (["--ratios", "0.1", "--k1", "0"], "k1 must be greater than 0"),
        (["--ratios", "0.1", "--C", "-1"], "C must be 0 or more; -1 N is given"),
        (["--ratios", "0.1", "--friction-ratio", "1.2"], "must not exceed 1; 1.2 is given"),
        (["--ratios", "0.1", "--friction-ratio", "0.8", "--A", "1"], "and A are both given"),
        (["--ratios", "0.1", "--friction-level", "7", "--C", "1"], "and C are both given"),
        (["--ratios", "0.1:1:10000", "--C", "1:2:10000"], "1e+08 lanes; at most 1e+07"),
        (["--ratios", "1e-6,0.1"], "of 1e-06 a cycle holds 7.1e+06 periods of the contact's ring"),
        (["--ratios", "0.1", "--k1", "1e13"], "at most 2e+04 can be computed"),
        (["--ratios", "0.1", "--contact", "sticky"], "'sticky' is not one of 'loaded', 'paper', 'smooth'"),
        (["--ratios", "0.1", "--derivative", "E"], "'E' is not one of"),
        (["--ratios", "0.1", "--chunk", "0"], "--chunk"),
        (["--ratios", "0.1", "--chunk", "many"], "'many' is not a valid integer"),
        (["--ratio", "0.1"], "No such option '--ratio'"),
        ([], "Missing option '--ratios'"),
    ],
)
def test_bad_options_are_one_sentence(rig, tmp_path, options, words):
    assert words in refusal(tmp_path, rig, *options, "--out", tmp_path / "out")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (RIG, "no run is listed with base_amplitude_mm, so the amplitude of the base has to be given"),
        (RIG.replace("1986.0\nlog_decrement = 0.207", "0") + RUN, "has stiffness 0 and so no natural"),
        (RIG.replace("C_n = 6.42\n", "") + RUN, "[assumed] does not give C, and no option does"),
        (RIG.partition("[assumed]")[0] + RUN, "[assumed] does not give C and k1"),
        (RIG.replace("207\n", "207\ndrive_stiffness_n_per_m = 0\n") + RUN, "by neither spring nor damper"),
        ("[assumed]\n", "no [rig] section"),
    ],
)
def test_a_rig_that_cannot_be_swept_is_one_sentence(tmp_path, text, words):
    rig = written(tmp_path / "rig.toml", text)
    found = refusal(tmp_path, rig, "--ratios", "0.5", "--out", tmp_path / "out")
    assert words in found and "rig.toml" in found


def test_a_missing_rig_is_one_sentence(tmp_path):
    words = refusal(tmp_path, tmp_path / "none.toml", "--ratios", "0.5", "--out", tmp_path / "out")
    assert "there is no such file" in words


def test_the_users_folder_is_not_touched(rig, tmp_path):
    (tmp_path / "mine").mkdir()
    written(tmp_path / "mine" / "thesis.txt", "years of work")
    for options in ([], ["--overwrite"]):
        words = refusal(tmp_path, rig, "--ratios", "0.5", "--out", tmp_path / "mine", *options)
        assert "not empty and was not written by jaxstick" in words
    assert "results may not replace" in refusal(tmp_path, rig, "--ratios", "0.5", "--out", tmp_path)


def test_a_scheduler_that_does_not_answer_is_one_sentence(rig, tmp_path, monkeypatch):
    monkeypatch.setattr(pytest.importorskip("jaxstick.sweeps.workers"), "PATIENCE", 0.5)
    for address in ("tcp://127.0.0.1:1", "nonsense://x"):
        words = refusal(tmp_path, rig, "--ratios", "0.5", "--scheduler", address, "--out", tmp_path / "out")
        assert f"{address}: no Dask scheduler answers there within" in words


def test_without_distributed_the_scheduler_is_one_sentence(rig, tmp_path, monkeypatch):
    monkeypatch.setattr(engine.importlib.util, "find_spec", lambda name: None)
    words = refusal(tmp_path, rig, "--ratios", "0.5", "--scheduler", "tcp://x:1", "--out", tmp_path / "out")
    assert "pip install 'jaxstick[cluster]'" in words


@pytest.fixture(scope="module")
def swept(tmp_path_factory) -> Path:
    """A sweep of 2 amplitudes and 12 ratios in chunks of 5, its JSON on standard output."""
    folder = tmp_path_factory.mktemp("sweep")
    rig = written(folder / "rig.toml")
    options = ["--ratios", RATIOS, "--amplitudes-mm", "8,10.325", "--chunk", "5"]
    result = sweep(rig, *options, "--out", folder / "out", "--json", "--quiet")
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert result.stdout == (folder / "out" / "sweep.json").read_text()
    return folder / "out"


def test_sweep_json_has_what_is_fixed(swept):
    content = json.loads((swept / "sweep.json").read_text())
    assert content["schema"] == 1 and isinstance(content["version"], str)
    lanes = content["lanes"]
    assert len(lanes) == 24
    for lane in lanes:
        assert lane["amplitude_ratio"] == pytest.approx(lane["amplitude_m"] / lane["base_amplitude_m"])
        natural = math.sqrt(1986.0 / 2.38) / (2 * math.pi)
        assert lane["frequency_ratio"] == pytest.approx(lane["frequency_hz"] / natural)
        assert len(lane["harmonics"]) == 9 and lane["energy_per_cycle_j"] > 0
        assert lane["period"] == 1 and lane["residual"] < 1e-9 and lane["stops"] in (0, 1, 2)
        assert 0 <= lane["stick_fraction"] < 1
    assert [lane["base_amplitude_m"] for lane in lanes] == [0.008] * 12 + [0.010325] * 12
    ratios = [lane["frequency_ratio"] for lane in lanes[:12]]
    assert ratios == sorted(ratios) and ratios[0] == 0.35 and ratios[-1] == 0.9


def test_the_csv_says_the_same(swept):
    lanes = json.loads((swept / "sweep.json").read_text())["lanes"]
    with (swept / "sweep.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(lanes)
    for row, lane in zip(rows, lanes, strict=True):
        for name in ("frequency_ratio", "base_amplitude_m", "amplitude_m", "stops", "residual"):
            assert float(row[name]) == lane[name]
        assert [float(row[f"harmonics_{n}"]) for n in range(1, 10)] == lane["harmonics"]
    assert (swept / "plots" / "amplitude.png").stat().st_size > 10_000


def test_chunks_make_no_difference(swept, tmp_path):
    options = ["--ratios", RATIOS, "--amplitudes-mm", "8,10.325"]
    rig = written(tmp_path / "rig.toml")
    assert sweep(rig, *options, "--out", tmp_path / "out", "--quiet").exit_code == 0
    assert (tmp_path / "out" / "sweep.json").read_bytes() == (swept / "sweep.json").read_bytes()
    assert "holds results already" in refusal(tmp_path, rig, *options, "--out", tmp_path / "out")


def start(rig: Path, out: Path, cache: Path, *options: object) -> subprocess.Popen[str]:
    """The command in a process of its own, two lanes a chunk."""
    command = [sys.executable, "-m", "jaxstick", "sweep", rig, "--ratios", "0.35:0.9:24", "--chunk", "2"]
    return subprocess.Popen(
        [*map(str, command), *map(str, options), "--out", str(out)],
        cwd=ROOT,
        env=os.environ | {"JAXSTICK_CACHE": str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def kept(out: Path) -> list[Path]:
    return sorted((out.parent / f".{out.name}.jaxstick-unfinished" / "kept").glob("*.chunk"))


def wait_for(chunks: int, out: Path, process: subprocess.Popen[str]) -> None:
    """Until so many chunks are kept."""
    end = time.monotonic() + 120
    while len(kept(out)) < chunks:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end, "no chunk within two minutes"
        time.sleep(0.01)


def test_a_killed_sweep_goes_on_where_it_was(rig, tmp_path):
    """Two kills, then the rest: what was finished is not computed again, and the result is the same."""
    whole, broken, cache = tmp_path / "whole", tmp_path / "broken", tmp_path / "cache"
    end = start(rig, whole, cache).communicate(timeout=120)
    assert (whole / "sweep.json").exists(), end
    seen: dict[str, int] = {}
    for chunks in (2, 5):
        process = start(rig, broken, cache)
        wait_for(chunks, broken, process)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        assert not broken.exists()
        times = {path.name: path.stat().st_mtime_ns for path in kept(broken)}
        assert seen.items() <= times.items(), "a finished chunk was computed again"
        seen = times
    half = kept(broken)[0]
    half.write_bytes(half.read_bytes()[:-7])
    last = start(rig, broken, cache)
    words, complaints = last.communicate(timeout=120)
    assert last.returncode == 0, complaints
    assert f"{2 * (len(seen) - 1)} of 24 lanes are finished already" in words
    for name in ("sweep.json", "sweep.csv", "plots/amplitude.png"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes()
    assert {path.name for path in tmp_path.iterdir()} - {"cache"} == {"broken", "rig.toml", "whole"}


def test_a_stopped_sweep_says_what_is_kept(rig, tmp_path, monkeypatch):
    compute, done = engine.compute, []

    def interrupted(points, **options):
        if done:
            raise KeyboardInterrupt
        done.append(True)
        return compute(points, **options)

    monkeypatch.setattr(engine, "compute", interrupted)
    options = [rig, "--ratios", "0.5,0.6,0.7", "--chunk", "2", "--out", tmp_path / "out"]
    result = sweep(*options)
    assert result.exit_code == 1
    assert "stopped before it was done; 2 of 3 lanes are kept, and the same command goes on" in result.stderr
    other = ["--ratios", "0.5,0.6", *options[3:]]
    assert "an unfinished sweep with other settings is kept here" in refusal(tmp_path, rig, *other)
    monkeypatch.undo()
    result = sweep(*options)
    assert result.exit_code == 0 and "2 of 3 lanes are finished already" in result.stdout
