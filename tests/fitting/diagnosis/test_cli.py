"""jaxstick diagnose: what it hands on, what it writes, what it refuses."""

from __future__ import annotations

import dataclasses
import json

import pytest
from click.testing import CliRunner, Result

from fitting import cli
from fitting.diagnosis.settings import DiagnosisSettings
from fitting.verbs import diagnose as verb
from tests.fitting.diagnosis.fabricated import LOOK_ALIKE, RIVAL, TRUTH, nothing_found


def jaxstick(*args: object) -> Result:
    return CliRunner().invoke(cli.jaxstick, [str(arg) for arg in args])


@pytest.fixture
def asked(diagnosis, monkeypatch) -> list[DiagnosisSettings]:
    """The command gets the made-up diagnosis, of one run; the settings it asked for are kept."""
    kept = []

    def run_diagnosis(data, settings, progress):
        kept.append(settings)
        progress.stage("nominal model", 1)
        progress.advance("chi² 46.7")
        return dataclasses.replace(diagnosis, sha256=data.sha256, traces=diagnosis.traces[:1])

    monkeypatch.setattr(verb, "run_diagnosis", run_diagnosis)
    return kept


def test_it_writes_the_report_and_says_the_same(asked, tiny_folder, tmp_path, diagnosis):
    out = tmp_path / "out"
    result = jaxstick("diagnose", tiny_folder, "--out", out)
    assert result.exit_code == 0, result.stderr
    content = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert content["named"] == [TRUTH] and content["data"]["name"] == "tiny"
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and content["data"]["sha256"] in page
    assert (out / "plots" / "probabilities.png").read_bytes().startswith(b"\x89PNG")
    for words in (
        diagnosis.sentence,
        "friction, 93 % of the excess",
        "98 % (95 % interval 97.1 to 99.4 %)",
        TRUTH,
        "0.1162 to 0.1203",
        "Constants",
        "differs",
        "What weakens it",
        "Next experiment: Turn the slider",
        str(out / "report.html"),
        str(out / "corrected_rig.toml"),
    ):
        assert words in result.stdout, words
    for stage in ("nominal model ...", "plots ...", "report ..."):
        assert stage in result.stderr


def test_json_is_alone_on_standard_output(asked, tiny_folder, tmp_path):
    out = tmp_path / "out"
    result = jaxstick("diagnose", tiny_folder, "--out", out, "--json")
    assert json.loads(result.stdout) == json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert "One effect named" in result.stderr
    quiet = jaxstick("diagnose", tiny_folder, "--out", out, "--overwrite", "--quiet")
    assert quiet.exit_code == 0 and quiet.output == ""


def test_it_hands_on_what_was_asked_for(asked, tiny_folder, tmp_path):
    jaxstick("diagnose", tiny_folder, "--out", tmp_path / "a", "--quiet")
    assert (asked[0].seed, asked[0].hold_out) == (0, ())
    jaxstick("diagnose", tiny_folder, "--out", tmp_path / "b", "--seed", 5, "--hold-out", "run-01.csv")
    assert (asked[1].seed, asked[1].hold_out) == (5, ("run-01.csv",))


@pytest.mark.parametrize(
    ("change", "said", "unsaid"),
    [
        ({}, "which                           none", "of the excess"),
        (
            {"verdict": "ambiguous", "named": (TRUTH, RIVAL)},
            f"{TRUTH} or {RIVAL}",
            "Next experiment",
        ),
        ({"verdict": "unlisted"}, "None of the listed effects", "Named effects"),
    ],
)
def test_other_verdicts_in_the_terminal(change, said, unsaid, diagnosis, tiny_folder, tmp_path, monkeypatch):
    found = dataclasses.replace(nothing_found(diagnosis), traces=diagnosis.traces[:1], **change)
    monkeypatch.setattr(verb, "run_diagnosis", lambda *_: found)
    result = jaxstick("diagnose", tiny_folder, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    assert not (tmp_path / "out" / "corrected_rig.toml").exists()
    assert said in result.stdout and unsaid not in result.stdout and "nan" not in result.stdout


@pytest.mark.parametrize("more", [(), (LOOK_ALIKE,)])
def test_two_together_in_the_terminal(more, diagnosis, tiny_folder, tmp_path, monkeypatch):
    found = dataclasses.replace(
        diagnosis,
        verdict="several",
        named=(TRUTH, RIVAL, *more),
        effects={TRUTH: diagnosis.effects[TRUTH], RIVAL: diagnosis.effects[TRUTH]},
        traces=diagnosis.traces[:1],
        correction=None,
    )
    monkeypatch.setattr(verb, "run_diagnosis", lambda *_: found)
    result = jaxstick("diagnose", tiny_folder, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    assert f"{TRUTH} with {RIVAL}" in result.stdout
    assert (f"or {LOOK_ALIKE} in the place of one" in result.stdout) == bool(more)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((), "Missing option '--out'"),
        (("--out", "OUT", "--hold-out", "run-9.csv"), "no run 'run-9.csv' to hold out; there are run-01.csv"),
        (
            ("--out", "OUT", "--hold-out", "run-01.csv", "--hold-out", "more/run-02.csv"),
            "no run is left to fit",
        ),
        (("--out", "DATA"), "results may not replace"),
    ],
)
def test_mistakes_are_found_before_anything_is_computed(args, words, tiny_folder, tmp_path, monkeypatch):
    monkeypatch.setattr(verb, "run_diagnosis", lambda *_: pytest.fail("a diagnosis was begun"))
    places = {"OUT": str(tmp_path / "out"), "DATA": str(tiny_folder)}
    result = jaxstick("diagnose", tiny_folder, *(places.get(arg, arg) for arg in args))
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1 and words in result.stderr and result.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_another_rig_file_takes_the_place_of_the_data_sets(asked, tiny_folder, tmp_path):
    rig = tmp_path / "other.toml"
    text = (tiny_folder / "rig.toml").read_text(encoding="utf-8")
    rig.write_text(text.replace('name = "tiny"', 'name = "other"'), encoding="utf-8")
    result = jaxstick("diagnose", tiny_folder, "--rig", rig, "--out", tmp_path / "out", "--json")
    assert json.loads(result.stdout)["data"]["name"] == "other"


def test_a_data_set_that_is_not_there(tmp_path):
    result = jaxstick("diagnose", tmp_path / "nowhere", "--out", tmp_path / "out")
    assert result.exit_code == 2 and "there is no such file or folder" in result.stderr


def test_a_diagnosis_that_fails_leaves_the_old_results(asked, tiny_folder, tmp_path, monkeypatch):
    out = tmp_path / "out"
    assert jaxstick("diagnose", tiny_folder, "--out", out, "--quiet").exit_code == 0
    before = (out / "report.html").read_bytes()

    def fails(*_):
        raise FloatingPointError("nothing fits")

    monkeypatch.setattr(verb, "run_diagnosis", fails)
    result = jaxstick("diagnose", tiny_folder, "--out", out, "--overwrite")
    assert result.exit_code == 1 and "FloatingPointError: nothing fits" in result.stderr
    assert (out / "report.html").read_bytes() == before
