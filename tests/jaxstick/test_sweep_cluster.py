"""A sweep on a real Dask scheduler with two worker processes, one of which is killed on the way."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from jaxstick import cli
from tests.jaxstick.rig_text import RIG

dask = pytest.importorskip("dask")
workers = pytest.importorskip("jaxstick.sweeps.workers")

ROOT = Path(__file__).resolve().parents[2]

OPTIONS = ("--ratios", "0.35:0.9:24", "--amplitudes-mm", "10.325", "--chunk", "2")

CHUNKS = 12
QUIET = 8.0
"""A worker that finishes nothing for so long [s] has nothing to do, or compiles."""


class Launch:
    """Starts modules of distributed as processes of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes: list[subprocess.Popen[bytes]] = []
        self._environment = os.environ | {
            "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]),
            "JAX_COMPILATION_CACHE_DIR": str(folder / "cache"),
            "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
        }

    def __call__(self, module: str, *options: str) -> subprocess.Popen[bytes]:
        with (self.folder / f"{module}-{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{module}", *options],
                cwd=self.folder,
                env=self._environment,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        self.processes.append(process)
        return process

    def end(self) -> None:
        """Ends what was started, workers first."""
        for process in reversed(self.processes):
            process.kill()
            process.wait(timeout=20)


@pytest.fixture
def launch(tmp_path) -> Iterator[Launch]:
    launch = Launch(tmp_path)
    yield launch
    launch.end()


@pytest.fixture
def scheduler(launch, tmp_path) -> str:
    """The address of a scheduler that listens on this machine alone."""
    file = tmp_path / "scheduler.json"
    process = launch(
        "dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
        "--scheduler-file",
        str(file),
    )
    end = time.monotonic() + 60
    while not file.exists():
        assert process.poll() is None, (tmp_path / "dask_scheduler-0.log").read_text()
        assert time.monotonic() < end, "no scheduler within a minute"
        time.sleep(0.05)
    time.sleep(0.1)
    return json.loads(file.read_text())["address"]


def worker(launch: Launch, address: str) -> subprocess.Popen[bytes]:
    """A worker with one thread that nobody starts again."""
    options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0")
    return launch("dask_worker", address, *options)


def kept(out: Path) -> int:
    """How many chunks are finished."""
    return len(list((out.parent / f".{out.name}.jaxstick-unfinished" / "kept").glob("*.chunk")))


def kill_halfway(victim: subprocess.Popen[bytes], out: Path, seen: list[int]) -> None:
    """Freezes a worker after the first chunk, so that it keeps the chunks it is at, and kills it when most
    are done, or the other one has nothing more to do: how many a worker keeps is up to the scheduler."""
    end = time.monotonic() + 120
    while kept(out) < 1 and time.monotonic() < end:
        time.sleep(0.01)
    victim.send_signal(signal.SIGSTOP)
    done, since = kept(out), time.monotonic()
    while done < CHUNKS - 4 and time.monotonic() < since + QUIET:
        time.sleep(0.01)
        if kept(out) > done:
            done, since = kept(out), time.monotonic()
    time.sleep(0.3)
    seen.append(kept(out))
    victim.send_signal(signal.SIGKILL)


def test_a_worker_that_is_killed_costs_nothing(launch, scheduler, tmp_path):
    rig = tmp_path / "rig.toml"
    rig.write_text(RIG, encoding="utf-8")
    victim, _ = worker(launch, scheduler), worker(launch, scheduler)
    seen: list[int] = []
    killer = threading.Thread(target=kill_halfway, args=(victim, tmp_path / "far", seen))
    killer.start()
    command = ["sweep", str(rig), *OPTIONS, "--quiet", "--out"]
    far = CliRunner().invoke(cli.jaxstick, [*command, str(tmp_path / "far"), "--scheduler", scheduler])
    killer.join()
    assert far.exit_code == 0, far.output
    assert far.output == ""
    assert 1 <= seen[0] < CHUNKS, "the worker was not killed on the way"
    assert victim.wait(timeout=20) == -signal.SIGKILL
    near = CliRunner().invoke(cli.jaxstick, [*command, str(tmp_path / "near")])
    assert near.exit_code == 0, near.output
    for name in ("sweep.json", "sweep.csv"):
        assert (tmp_path / "far" / name).read_bytes() == (tmp_path / "near" / name).read_bytes()


def test_a_scheduler_without_workers_is_one_sentence(scheduler, tmp_path, monkeypatch):
    monkeypatch.setattr(workers, "PATIENCE", 0.5)
    rig = tmp_path / "rig.toml"
    rig.write_text(RIG, encoding="utf-8")
    out = tmp_path / "out"
    result = CliRunner().invoke(
        cli.jaxstick, ["sweep", str(rig), *OPTIONS, "--scheduler", scheduler, "--out", str(out)]
    )
    assert result.exit_code == 2
    assert result.stderr == (
        f"jaxstick: {scheduler}: the Dask scheduler there has no workers; none came within 0.5 s.\n"
    )
    assert not out.exists()


def test_a_scheduler_that_dies_leaves_what_is_finished(launch, scheduler, tmp_path, monkeypatch):
    """The sweep ends with 1 and one sentence; without the cluster it goes on where it was."""
    monkeypatch.setitem(dask.config.get("distributed.comm.timeouts"), "connect", "1s")
    rig, out = tmp_path / "rig.toml", tmp_path / "out"
    rig.write_text(RIG, encoding="utf-8")
    worker(launch, scheduler)
    command = ["sweep", str(rig), *OPTIONS, "--out", str(out)]
    killer = threading.Thread(target=kill_after_a_chunk, args=(launch.processes[0], out))
    killer.start()
    result = CliRunner().invoke(cli.jaxstick, [*command, "--quiet", "--scheduler", scheduler])
    killer.join()
    assert result.exit_code == 1
    assert "the connection to the Dask scheduler is lost;" in result.stderr
    assert "of 24 lanes are kept, and the same command goes on from there." in result.stderr
    assert result.stderr.count("\n") == 1
    done = 2 * kept(out)
    assert 0 < done < 24
    result = CliRunner().invoke(cli.jaxstick, command)
    assert result.exit_code == 0
    assert f"{done} of 24 lanes are finished already." in result.stdout


def kill_after_a_chunk(process: subprocess.Popen[bytes], out: Path) -> None:
    """Ends a process when the first chunk is finished."""
    while kept(out) < 1:
        time.sleep(0.005)
    process.kill()
