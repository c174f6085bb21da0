"""The lower commands: what they print and write, and how they end."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from jaxstick import cli
from jaxstick.catalogue import catalogue
from jaxstick.record import load_dataset, load_rig
from jaxstick.simulations import simulations
from jaxstick.verbs import check as check_verb
from tests.jaxstick import datasets, rig_text

ROOT = Path(__file__).resolve().parents[2]

RIG = (
    rig_text.RIG
    + """\
[[run]]
frequency_hz = 1.5
base_amplitude_mm = 10.325
cycles = 4
sample_rate_hz = 200
"""
)


def jaxstick(*args: object) -> Result:
    return CliRunner().invoke(cli.jaxstick, [str(arg) for arg in args])


def python(*args: object) -> subprocess.CompletedProcess[str]:
    """The interpreter in a process of its own, with no cache."""
    return subprocess.run(
        [sys.executable, *map(str, args)],
        cwd=ROOT,
        env=os.environ | {"JAXSTICK_CACHE": "off"},
        capture_output=True,
        text=True,
        timeout=120,
    )


def sentence(result: Result) -> str:
    """What stands on standard error: one line."""
    assert result.stderr.count("\n") == 1 and result.stderr.endswith("\n"), result.stderr
    return result.stderr.strip()


@pytest.fixture
def dataset(tmp_path) -> Path:
    return datasets.write(tmp_path / "data")


@pytest.fixture
def rig(tmp_path) -> Path:
    path = tmp_path / "one-run.toml"
    path.write_text(RIG, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def simulated(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("simulated")
    (folder / "one-run.toml").write_text(RIG, encoding="utf-8")
    result = jaxstick("simulate", folder / "one-run.toml", "--out", folder / "out", "--json")
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout) == json.loads((folder / "out" / "simulation.json").read_text())
    return folder / "out"


def test_check_shows_tables_and_findings(dataset):
    result = jaxstick("check", dataset)
    assert result.exit_code == 0
    assert "run-01.csv" in result.stdout and "natural frequency" in result.stdout
    assert "no run is held out" in result.stdout
    assert result.stderr == ""


def test_json_alone_on_standard_output_and_words_on_standard_error(dataset):
    result = jaxstick("check", dataset, "--json")
    assert json.loads(result.stdout)["runs"][0]["file"] == "run-01.csv"
    assert "natural frequency" in result.stderr


def test_quiet_says_nothing_but_the_result(dataset):
    assert jaxstick("check", dataset, "--quiet").output == ""
    result = jaxstick("check", dataset, "--quiet", "--json")
    assert json.loads(result.stdout)["name"] and result.stderr == ""


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["check"], "Missing argument 'DATASET'; see jaxstick check --help."),
        (["check", "nowhere"], "nowhere: there is no such file or folder."),
        (["check", "a", "b"], "unexpected extra argument"),
        (["check", "a", "--seed", "-1"], "--seed"),
        (["chek"], "No such command 'chek' (did you mean 'check'?); see jaxstick --help."),
        (["simulate", "nowhere", "--out", "out"], "nowhere: there is no such file or folder."),
        (["effects", "no_such_effect"], "There is no effect called 'no_such_effect'"),
    ],
)
def test_a_mistake_is_one_sentence_and_ends_with_2(args, words):
    result = jaxstick(*args)
    assert result.exit_code == 2
    assert words in sentence(result)
    assert sentence(result).startswith("jaxstick: ") and sentence(result).endswith((".", "?"))
    assert result.stdout == ""


def test_a_failure_of_ours_is_one_sentence_and_ends_with_1(dataset, monkeypatch):
    def fails(_):
        raise RuntimeError("first line\nsecond line")

    monkeypatch.setattr(check_verb, "describe", fails)
    monkeypatch.delenv("JAXSTICK_DEBUG", raising=False)
    result = jaxstick("check", dataset)
    assert result.exit_code == 1
    assert "RuntimeError: first line second line" in sentence(result)
    monkeypatch.setenv("JAXSTICK_DEBUG", "1")
    result = jaxstick("check", dataset)
    assert result.exit_code == 1 and "Traceback" in result.stderr and "in fails" in result.stderr


def test_stopping_it_is_said(dataset, monkeypatch):
    def stopped(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(check_verb, "describe", stopped)
    result = jaxstick("check", dataset)
    assert result.exit_code == 1
    assert result.stderr.strip() == "jaxstick: stopped before it was done; nothing was written."


def test_help_and_version_end_with_0():
    for args in ([], ["--help"], ["simulate", "--help"], ["--version"]):
        result = jaxstick(*args)
        assert result.exit_code == 0 and "jaxstick" in result.stdout and result.stderr == ""


def test_effects_lists_the_shelf_and_shows_a_card():
    listed = jaxstick("effects", "--json")
    entries = json.loads(listed.stdout)["effects"]
    assert set(entries) == set(catalogue())
    for key, effect in catalogue().items():
        assert entries[key]["title"] == effect.card.title and entries[key]["parameters"][0]["unit"]
        assert key in listed.stderr
    key = next(iter(entries))
    card = jaxstick("effects", key)
    assert card.exit_code == 0
    for part in ("symptom", "explanation", "remedy", "source"):
        assert entries[key][part].split()[-1] in card.stdout


def test_simulate_makes_a_data_set_of_what_was_simulated(simulated):
    data = load_dataset(simulated)
    expected = simulations(load_rig(simulated.parent / "one-run.toml")).runs[0]
    (run,) = data.runs
    np.testing.assert_array_equal(run.time, expected.time)
    for channel in ("displacement", "friction", "base"):
        np.testing.assert_array_equal(run.channels[channel], expected.channels[channel])
    assert run.assumed == expected.assumed
    assert (simulated / "plots" / "run-01.png").read_bytes().startswith(b"\x89PNG")
    entry = json.loads((simulated / "simulation.json").read_text())["runs"][0]
    assert entry["stops"] == 2
    assert entry["amplitude_m"] == pytest.approx(0.0096, rel=0.01)
    assert entry["frequency_hz"] == pytest.approx(1.5, rel=1e-6) and entry["measured"] is None


def test_simulate_beside_a_record_says_how_far_off_it_is(simulated, tmp_path):
    result = jaxstick("simulate", simulated, "--out", tmp_path / "again", "--json")
    assert result.exit_code == 0, result.stderr
    measured = json.loads(result.stdout)["runs"][0]["measured"]
    assert measured["stops"] == pytest.approx(2, abs=0.3)
    assert measured["rms_displacement_m"] < 5e-5 and measured["rms_friction_n"] < 0.2


def test_simulate_without_a_frequency_is_refused_and_leaves_nothing(rig, tmp_path):
    rig.write_text(RIG.replace("frequency_hz = 1.5\n", ""), encoding="utf-8")
    result = jaxstick("simulate", rig, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "run-01.csv has no frequency_hz" in sentence(result)
    assert [path.name for path in tmp_path.iterdir()] == ["one-run.toml"]


def test_results_are_replaced_only_when_asked(simulated, rig):
    before = (simulated / "simulation.json").read_bytes()
    result = jaxstick("simulate", rig, "--out", simulated)
    assert result.exit_code == 2 and "--overwrite" in sentence(result)
    assert (simulated / "simulation.json").read_bytes() == before
    assert jaxstick("simulate", rig, "--out", simulated, "--overwrite", "--quiet").output == ""


def test_check_and_help_import_neither_jax_nor_matplotlib(dataset):
    script = (
        "import sys; from jaxstick.cli import jaxstick\n"
        "try: jaxstick(sys.argv[1:], prog_name='jaxstick')\n"
        "except SystemExit as end: print(end.code, sorted({'jax', 'matplotlib', 'scipy'} & set(sys.modules)))"
    )
    for args in (["check", dataset, "--quiet"], ["--help"]):
        done = python("-c", script, *args)
        assert done.stdout.splitlines()[-1] == "0 []", done.stderr


def test_as_a_module_it_checks_and_closes_its_pipe_quietly(dataset):
    done = python("-m", "jaxstick", "check", dataset, "--json", "--quiet")
    assert done.returncode == 0 and json.loads(done.stdout)["name"] == "data" and done.stderr == ""
    done = python("-m", "jaxstick", "check", dataset.parent)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and done.stdout == ""
