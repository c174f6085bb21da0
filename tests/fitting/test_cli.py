"""The whole command: fit and compare, beside the lower verbs."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from fitting import cli
from fitting.settings import Settings
from fitting.verbs import fit as fit_verb
from jaxstick.progress_bar import ProgressBar
from jaxstick.terminal import Terminal

ROOT = Path(__file__).resolve().parents[2]


def jaxstick(*args: object) -> Result:
    return CliRunner().invoke(cli.jaxstick, [str(arg) for arg in args])


def sentence(result: Result) -> str:
    """The last line on standard error."""
    return result.stderr.strip().splitlines()[-1]


@pytest.fixture
def asked(fitted, monkeypatch) -> list[Settings]:
    """The command gets the fit that is there already; the settings it asked for are kept."""
    kept = []

    def run_fit(data, settings, progress):
        kept.append(settings)
        progress.stage("descent", 2)
        progress.advance("loss 1")
        return dataclasses.replace(fitted, sha256=data.sha256)

    monkeypatch.setattr(fit_verb, "run_fit", run_fit)
    return kept


@pytest.fixture(scope="module")
def done(fitted, tiny_folder, tmp_path_factory) -> tuple[Path, Result]:
    out = tmp_path_factory.mktemp("fit") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fit_verb, "run_fit", lambda data, settings, progress: fitted)
        result = jaxstick("fit", tiny_folder, "--out", out)
    assert result.exit_code == 0, result.stderr
    return out, result


def test_fit_writes_results_and_says_what_they_mean(done):
    out, result = done
    content = json.loads((out / "fit.json").read_text(encoding="utf-8"))
    assert content["outcome"] == "converged"
    assert (out / "traces" / "run-01.csv").exists() and (out / "traces" / "more" / "run-02.csv").exists()
    assert (out / "plots" / "friction-law.png").read_bytes().startswith(b"\x89PNG")
    for words in ("identified", "95 % interval", "What the fit leaves", "What is left is noise", str(out)):
        assert words in result.stdout
    assert "differs" in result.stdout and "run-01.csv" in result.stdout
    loose = [name for name, entry in content["constants"].items() if not entry["identifiable"]]
    assert f"{' and '.join(loose)} {'is' if len(loose) == 1 else 'are'} not bounded" in result.stdout


def test_fit_prints_fit_json_alone(asked, tiny_folder, tmp_path):
    result = jaxstick("fit", tiny_folder, "--out", tmp_path / "out", "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout) == json.loads((tmp_path / "out" / "fit.json").read_text())
    assert "descent ..." in result.stderr and "95 % interval" in result.stderr
    quiet = jaxstick("fit", tiny_folder, "--out", tmp_path / "out", "--overwrite", "--quiet")
    assert quiet.exit_code == 0 and quiet.output == ""


def test_fit_hands_on_what_was_asked_for(asked, tiny_folder, tmp_path):
    jaxstick("fit", tiny_folder, "--out", tmp_path / "a")
    assert asked[0] == Settings()
    shelf = json.loads(jaxstick("effects", "--json").stdout)["effects"]
    key = next(iter(shelf))
    options = ("--with", key, "--free", "mass", "--free", "damping", "--starts", 3, "--seed", 5)
    jaxstick("fit", tiny_folder, "--out", tmp_path / "b", *options, "--horizon", "record")
    assert asked[1] == Settings(
        horizon=None, effects=(key,), free=("mass", "damping"), starts=3, seed=5, workers=asked[1].workers
    )
    jaxstick("fit", tiny_folder, "--out", tmp_path / "c", "--horizon", "2.5")
    assert asked[2].horizon == 2.5


def test_a_fit_that_did_not_converge_is_written_said_and_ends_with_1(
    fitted, tiny_folder, tmp_path, monkeypatch
):
    lost = dataclasses.replace(fitted, outcome="the search did not converge")
    monkeypatch.setattr(fit_verb, "run_fit", lambda data, settings, progress: lost)
    for options in ((), ("--quiet", "--json")):
        out = tmp_path / f"out{len(options)}"
        result = jaxstick("fit", tiny_folder, "--out", out, *options)
        assert result.exit_code == 1
        assert sentence(result).endswith("is not to be relied on: the search did not converge.")
        assert json.loads((out / "fit.json").read_text())["outcome"] == "the search did not converge"


def test_a_fit_that_fails_leaves_the_old_results(done, tiny_folder, monkeypatch):
    out, _ = done
    before = (out / "fit.json").read_bytes()

    def fails(*_):
        raise FloatingPointError("nothing fits")

    monkeypatch.setattr(fit_verb, "run_fit", fails)
    result = jaxstick("fit", tiny_folder, "--out", out, "--overwrite")
    assert result.exit_code == 1 and "FloatingPointError: nothing fits" in sentence(result)
    assert (out / "fit.json").read_bytes() == before
    assert [path.name for path in out.parent.iterdir()] == ["out"]


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((), "Missing option '--out'"),
        (("--out", "OUT", "--with", "no_such_effect"), "There is no effect called 'no_such_effect'"),
        (("--out", "OUT", "--free", "colour"), "'colour' is not one of 'mass', 'stiffness'"),
        (("--out", "OUT", "--horizon", "-1"), "'-1' is neither a positive number"),
        (("--out", "OUT", "--horizon", "inf"), "'inf' is neither a positive number"),
        (("--out", "OUT", "--starts", "0"), "--starts"),
        (("--out", "DATA"), "results may not replace"),
        (("--out", "DATA/rig.toml"), "this is a file; results go to a folder"),
    ],
)
def test_mistakes_are_found_before_anything_is_fitted(args, words, tiny_folder, tmp_path, monkeypatch):
    monkeypatch.setattr(fit_verb, "run_fit", lambda *_: pytest.fail("a fit was begun"))
    places = {
        "OUT": str(tmp_path / "out"),
        "DATA": str(tiny_folder),
        "DATA/rig.toml": str(tiny_folder / "rig.toml"),
    }
    result = jaxstick("fit", tiny_folder, *(places.get(arg, arg) for arg in args))
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1 and words in result.stderr and result.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_compare_says_how_far_apart_and_what_changes(done):
    out, _ = done
    result = jaxstick("compare", out / "fit.json")
    assert result.exit_code == 0, result.stderr
    for words in ("s.e. apart", "amplitude", "stops", "What each identified constant alone changes", "runs"):
        assert words in result.stdout
    found = json.loads(jaxstick("compare", out, "--json", "--quiet").stdout)
    assert found["schema"] == 1 and set(found["constants"]) == {"A", "B", "C", "D", "k1"}
    run = found["runs"][0]
    assert run["frequency_hz"] == pytest.approx(1.5, rel=1e-3)
    for case in (run["measured"], run["assumed"], run["identified"], run["exchanged"]["C"]):
        assert case["amplitude_m"] == pytest.approx(0.0096, rel=0.1) and case["stops"] == pytest.approx(
            2, abs=0.5
        )


def test_compare_with_a_data_set_and_with_a_rig(done, tiny_folder, tmp_path):
    out, _ = done
    found = json.loads(jaxstick("compare", out, tiny_folder, "--json", "--quiet").stdout)
    assert found["runs"][1]["measured"]["stops"] >= 2 and found["data"]["compared"] == found["data"]["fitted"]
    rig = tmp_path / "rig.toml"
    rig.write_text(
        "[rig]\nmass_kg = 2.38\nstiffness_n_per_m = 1986\nlog_decrement = 0.2\n"
        "[assumed]\nC_n = 6\nk1_n_per_m = 9e4\n"
        "[[run]]\nfrequency_hz = 1.0\nbase_amplitude_mm = 9\n",
        encoding="utf-8",
    )
    found = json.loads(jaxstick("compare", out, rig, "--json", "--quiet").stdout)
    assert found["constants"]["C"]["assumed"] == 6 and found["constants"]["A"]["assumed"] is None
    assert found["runs"][0]["measured"] is None and found["runs"][0]["assumed"]["amplitude_m"] > 0.006
    rig.write_text("[rig]\nmass_kg = 2.38\nstiffness_n_per_m = 1986\nlog_decrement = 0.2\n", encoding="utf-8")
    result = jaxstick("compare", out, rig)
    assert result.exit_code == 2 and "no run is listed" in sentence(result)


def test_compare_wants_a_fit(tiny_folder):
    result = jaxstick("compare", tiny_folder)
    assert result.exit_code == 2 and "there is no such file" in sentence(result)


def test_help_lists_every_verb_without_jax():
    script = (
        "import sys; from fitting.cli import jaxstick\n"
        "try: jaxstick(['--help'], prog_name='jaxstick')\n"
        "except SystemExit: print(sorted({'jax', 'matplotlib', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, timeout=60
    )
    lines = done.stdout.splitlines()
    assert lines[-1] == "[]", done.stderr
    for verb in ("check", "simulate", "effects", "fit", "compare"):
        assert any(line.split()[:1] == [verb] for line in lines)


def test_in_a_process_of_its_own_it_compares(done):
    out, _ = done
    done_ = subprocess.run(
        [sys.executable, "-m", "fitting", "compare", str(out), "--json"],
        cwd=ROOT,
        env=os.environ | {"JAXSTICK_CACHE": "off"},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done_.returncode == 0, done_.stderr
    assert json.loads(done_.stdout)["runs"] and "s.e. apart" in done_.stderr


def test_progress_is_a_line_a_stage_off_a_terminal(capsys):
    with ProgressBar(Terminal().progress_console()) as bar:
        bar.stage("descent", 0)
        bar.advance("loss 1")
        bar.advance("loss 1")
        bar.stage("least squares", 3)
    out, err = capsys.readouterr()
    assert (out, err) == ("", "descent ...\nleast squares ...\n")
    with ProgressBar(Terminal(quiet=True).progress_console()) as bar:
        bar.stage("descent", 1)
    assert capsys.readouterr() == ("", "")
