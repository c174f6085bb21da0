"""Making sets of cases: whole, after a kill, around a case that fails; and spikes on given records."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fitting.blind import making
from fitting.blind.making import make_cases
from fitting.blind.seal import checksums, new_key, open_seal
from fitting.cli import jaxstick as command
from fitting.progress import Silent
from jaxstick.errors import UserError
from jaxstick.record import load_dataset, save_dataset
from tests.fitting.blind.small import SETTINGS

CHANGED = ("displacement", "friction")
RIG1987 = Path(__file__).resolve().parents[3] / "data" / "rig1987"


def make(out: Path, key: str, count: int = 4, **options):
    return make_cases(out, count, SETTINGS, key, Silent(), workers=1, **options)


def test_a_set_that_was_stopped_is_taken_up_again(tmp_path, monkeypatch):
    key = new_key()
    whole = make(tmp_path / "whole", key)
    assert (whole.cases, whole.failed, whole.new) == (4, {}, 4)
    real, calls = making.make_one, []

    def stopped(task, *rest):
        calls.append(task.number)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return real(task, *rest)

    monkeypatch.setattr(making, "make_one", stopped)
    with pytest.raises(KeyboardInterrupt):
        make(tmp_path / "cut", key)
    with pytest.raises(UserError, match="no finished set"):
        open_seal(tmp_path / "cut", key)
    with pytest.raises(UserError, match="other options"):
        make(tmp_path / "cut", key, count=5)
    resumed = make(tmp_path / "cut", key)
    assert (resumed.cases, resumed.new) == (4, 2)
    first, second = open_seal(tmp_path / "whole", key), open_seal(tmp_path / "cut", key)
    assert first.answers == second.answers
    assert first.manifest["cases"] == second.manifest["cases"]
    with pytest.raises(UserError, match="sealed set of cases already"):
        make(tmp_path / "cut", key)


def test_a_case_that_fails_ends_nothing(tmp_path, monkeypatch):
    real = making.draw_case

    def failing(settings, number, assignment):
        if number == 2:
            raise ZeroDivisionError("planted")
        return real(settings, number, assignment)

    monkeypatch.setattr(making, "draw_case", failing)
    key = new_key()
    made = make(tmp_path, key, count=3)
    assert made.cases == 2
    assert "planted" in made.failed["case-0002"]
    opened = open_seal(tmp_path, key)
    assert set(opened.answers) == {"case-0001", "case-0003"}
    assert opened.manifest["failed"] == ["case-0002"]


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(UserError, match="not empty"):
        make(tmp_path, new_key())


def test_spikes_on_given_records(tmp_path):
    key = new_key()
    made = make(tmp_path / "cases", key, count=6, spike_on=[RIG1987])
    assert made.failed == {}
    original = load_dataset(RIG1987)
    sizes = set()
    spiked = 0
    for name, answer in open_seal(tmp_path / "cases", key).answers.items():
        case = load_dataset(tmp_path / "cases" / name)
        sizes.add(tuple((tmp_path / "cases" / name / run.file).stat().st_size for run in case.runs))
        changed = [
            not all(
                np.allclose(one.channels[name], two.channels[name], atol=0, rtol=1e-9) for name in CHANGED
            )
            for one, two in zip(case.runs, original.runs, strict=True)
        ]
        assert all(changed) if answer["truth"] != ["none"] else not any(changed)
        assert answer["tier"] == "D"
        spiked += any(changed)
    assert spiked == 4
    assert len(sizes) == 1
    with pytest.raises(UserError, match="no fault can be put on it"):
        make(tmp_path / "more", key, spike_on=[tmp_path])


def test_faults_are_as_large_as_is_asked_for(tmp_path):
    key, large = new_key(), replace(SETTINGS, spike_times=(40.0, 60.0))
    source = tmp_path / "motion-alone"
    stated = load_dataset(RIG1987)
    save_dataset(replace(stated, runs=tuple(replace(run, friction=None) for run in stated.runs)), source)
    made = make_cases(tmp_path / "cases", 6, large, key, Silent(), workers=1, spike_on=[source])
    assert made.failed == {}
    answers = open_seal(tmp_path / "cases", key).answers.values()
    sizes = [answer["gap_ratio"] for answer in answers if answer["truth"] != ["none"]]
    assert len(sizes) == 4 and all(36 < size < 66 for size in sizes)


def test_no_fault_is_put_on_a_channel_that_was_not_recorded(tmp_path):
    """Where there is no friction force, the displacement alone may be spiked."""
    source = tmp_path / "motion-alone"
    stated = load_dataset(RIG1987)
    runs = tuple(replace(run, friction=None) for run in stated.runs)
    save_dataset(replace(stated, runs=runs, noise=replace(stated.noise, friction=None)), source)
    key = new_key()
    assert make(tmp_path / "cases", key, count=6, spike_on=[source]).failed == {}
    for answer in open_seal(tmp_path / "cases", key).answers.values():
        (truth,) = answer["truth"]
        assert truth == "none" or (truth.startswith("displacement_") and answer["gap_ratio"] > 1)


def run_command(capsys, *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as ended:
        command(list(words), prog_name="jaxstick")
    out, err = capsys.readouterr()
    return int(ended.value.code or 0), out, err


def test_the_command_makes_and_seals(tmp_path, capsys):
    folder, key_file = tmp_path / "cases", tmp_path / "key"
    words = ("blind", "make", "--cases", "2", "--seed", "3", "--out", str(folder), "--runs", "2")
    more = ("--samples", "600", "--workers", "1", "--key-file", str(key_file), "--json", "--tiers", "A")
    code, out, _ = run_command(capsys, *words, *more, "--kind", "none,single")
    assert code == 0
    assert json.loads(out) == {"cases": 2, "failed": {}, "new": 2}
    opened = open_seal(folder, key_file.read_text())
    assert {answer["tier"] for answer in opened.answers.values()} == {"A"}
    assert checksums(folder / "case-0001") == opened.manifest["cases"]["case-0001"]
    code, _, err = run_command(capsys, *words, *more)
    assert code == 2 and "sealed set" in err
    inside = ("--key-file", str(folder / "key"))
    code, _, err = run_command(capsys, *words, *inside)
    assert code == 2 and "may not lie in the folder" in err
    code, _, err = run_command(capsys, *words, "--kind", "double")
    assert code == 2 and "'double' is none of" in err
    for sizes in (("9", "3", "--spike-on", str(RIG1987)), ("3", "9")):
        code, _, err = run_command(capsys, *words, "--spike-times", *sizes)
        assert code == 2 and f"--spike-times {sizes[0]} {sizes[1]}: expected" in err


def test_another_purpose_makes_other_cases(tmp_path):
    key = new_key()
    make(tmp_path / "one", key, count=1)
    judging = replace(SETTINGS, family="judging")
    make_cases(tmp_path / "two", 1, judging, key, Silent(), workers=1)
    one, two = (open_seal(tmp_path / name, key).manifest for name in ("one", "two"))
    assert one["cases"] != two["cases"]
    assert one["seed_sha256"] != two["seed_sha256"]
