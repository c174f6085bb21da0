"""Work in a second process: done there, else here."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest

from fitting.aside import Aside
from jaxstick.deferred import Deferred, deferred

HERE = os.getpid()


def say_who(path: Path) -> None:
    path.write_text(str(os.getpid()), encoding="utf-8")


def fail_elsewhere(path: Path, here: int) -> None:
    if os.getpid() != here:
        raise RuntimeError("no")
    say_who(path)


def die_elsewhere(path: Path, here: int) -> None:
    if os.getpid() != here:
        os.kill(os.getpid(), signal.SIGTERM)
    say_who(path)


def fail(path: Path) -> None:
    raise RuntimeError(f"no {path.name}")


def wait_long(path: Path) -> None:
    path.touch()
    time.sleep(600)


def in_this_file(name: str) -> Deferred:
    return deferred(__name__, name)


def test_it_is_done_by_another_process(tmp_path):
    with Aside(in_this_file("say_who")) as aside:
        aside.begin(tmp_path / "who")
        aside.end()
    assert int((tmp_path / "who").read_text()) != HERE


@pytest.mark.parametrize("work", ["fail_elsewhere", "die_elsewhere"])
def test_what_fails_there_is_done_here(tmp_path, work):
    with Aside(in_this_file(work)) as aside:
        aside.begin(tmp_path / "who", HERE)
        aside.end()
    assert int((tmp_path / "who").read_text()) == HERE


def test_where_no_process_can_be_had_it_is_done_here(tmp_path, monkeypatch):
    def refuse(self):
        raise OSError("no more processes")

    monkeypatch.setattr("multiprocessing.context.SpawnProcess.start", refuse)
    with Aside(in_this_file("say_who")) as aside:
        aside.begin(tmp_path / "who")
        aside.end()
    assert int((tmp_path / "who").read_text()) == HERE


def test_what_fails_here_too_is_said(tmp_path):
    with pytest.raises(RuntimeError, match="no who"), Aside(in_this_file("fail")) as aside:
        aside.begin(tmp_path / "who")
        aside.end()


def test_nobody_waits_for_it_once_the_block_is_left(tmp_path):
    with pytest.raises(KeyboardInterrupt), Aside(in_this_file("wait_long")) as aside:
        process = aside._process
        aside.begin(tmp_path / "begun")
        while not (tmp_path / "begun").exists():
            time.sleep(0.01)
        raise KeyboardInterrupt
    assert process is not None and not process.is_alive()


def test_there_is_none_outside_the_block():
    with pytest.raises(RuntimeError, match="within the `with` block"):
        Aside(in_this_file("fail")).begin()
