"""fit.json and the traces: what is written, and what is read back."""

from __future__ import annotations

import csv
import dataclasses
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.against import against, figures, stated
from fitting.save import fit_content, save_fit
from fitting.saved import read_fit
from fitting.show import show_fit
from jaxstick.cycle import Cycle
from jaxstick.errors import UserError
from jaxstick.output import OutputFolder, to_json
from tests.fitting.tiny import ASSUMED, TRUE


@pytest.fixture(scope="module")
def folder(fitted, tiny, tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "out"
    with OutputFolder(path) as output:
        save_fit(fitted, tiny, output)
    return path


@pytest.fixture
def content(folder):
    return json.loads((folder / "fit.json").read_text(encoding="utf-8"))


def test_the_fixed_keys(content, fitted, tiny):
    assert content["schema"] == 1 and content["outcome"] == fitted.outcome == "converged"
    assert list(content["constants"]) == ["A", "B", "C", "D", "k1"]
    for constant in fitted.constants:
        entry = content["constants"][constant.name]
        assert (entry["value"], entry["low"], entry["high"]) == (constant.value, constant.low, constant.high)
        assert (entry["unit"], entry["assumed"]) == (constant.unit, getattr(ASSUMED, constant.name))
        assert entry["identifiable"] is (constant.low is not None and constant.high is not None)
    assert content["constants"]["C"]["value"] == pytest.approx(TRUE.C, abs=0.02)
    assert [(gap["file"], gap["channel"]) for gap in content["gap"]["runs"]] == [
        (run.file, channel) for run in tiny.runs for channel in ("displacement", "friction")
    ]
    for gap in content["gap"]["runs"]:
        assert {"rms", "nrms_percent", "floor"} < set(gap)
    assert content["gap"]["chi2_per_sample"] == pytest.approx(1.0, abs=0.2)
    for run, free in zip(content["free_run"], fitted.free_runs, strict=True):
        assert (run["file"], run["rms_displacement_m"]) == (free.file, free.rms_displacement)
        assert run["nrms_percent"] == free.nrms_percent
    assert content["data"]["sha256"] == tiny.sha256 and len(tiny.sha256) == 64
    assert content["version"]


def test_what_is_not_bounded_is_null(fitted, tiny):
    loose = dataclasses.replace(fitted.constants[3], low=None, high=None, standard_error=None)
    one_sided = dataclasses.replace(fitted.constants[4], high=None)
    changed = dataclasses.replace(fitted, constants=(*fitted.constants[:3], loose, one_sided))
    entries = json.loads(to_json(fit_content(changed, tiny)))["constants"]
    assert entries["D"]["low"] is None and entries["D"]["high"] is None
    assert entries["D"]["standard_errors"] is None and entries["D"]["inside"] is None
    assert (entries["D"]["identifiable"], entries["k1"]["identifiable"]) == (False, False)
    assert entries["D"]["remark"] == "not bounded by these records"
    assert entries["k1"]["remark"] == "bounded only below, agrees"


def test_nothing_of_this_machine_is_in_it(content):
    text = json.dumps(content)
    assert "workers" not in text and "/tmp" not in text and "/home" not in text and "pytest" not in text


def test_traces_hold_measured_fitted_and_free_run(folder, fitted):
    for trace in fitted.traces:
        with (folder / "traces" / trace.run.file).open(encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        columns = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
        np.testing.assert_array_equal(columns["time_s"], trace.run.time)
        for name, values in {
            "displacement_m": trace.run.displacement,
            "fitted_displacement_m": trace.displacement,
            "free_run_displacement_m": trace.free_displacement,
            "friction_n": trace.run.friction,
            "fitted_friction_n": trace.friction,
            "free_run_friction_n": trace.free_friction,
        }.items():
            np.testing.assert_allclose(columns[name], values, rtol=1e-8, atol=1e-15)
        starts = np.flatnonzero(np.diff(columns["segment"], prepend=-1.0))
        np.testing.assert_array_equal(starts, trace.segment_starts)
        excluded = columns["excluded"][starts].astype(bool)
        np.testing.assert_array_equal(excluded, trace.excluded)


def test_it_reads_back(folder, content, tiny):
    saved = read_fit(folder)
    assert saved.path == folder / "fit.json" and saved.content == content
    assert (saved.rig, saved.assumed) == (tiny.rig, ASSUMED)
    assert [run.file for run in saved.runs] == [run.file for run in tiny.runs]
    for run, recorded in zip(saved.runs, tiny.runs, strict=True):
        assert run.rig == recorded.rig and run.assumed == recorded.assumed
        assert isinstance(run.cycle, Cycle) and run.cycle.frequency == pytest.approx(recorded.frequency, 1e-4)
        assert run.measured is not None and run.measured.cycles == 2
    assert read_fit(folder / "fit.json").constants == saved.constants


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("no json", "is not JSON"),
        ("[1]", "holds no constants"),
        ('{"schema": 7, "constants": {}}', "its schema is 7"),
        ('{"schema": 1, "constants": {"A": 1}}', "is not as jaxstick fit writes it"),
        ('{"schema": 1, "constants": {"A": {"value": "much"}}}', "is not as jaxstick fit writes it"),
        ("\udc80", "is not JSON"),
    ],
)
def test_a_file_that_is_no_fit_is_refused(text, words, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    with pytest.raises(UserError, match=words) as error:
        read_fit(path)
    assert str(path) in str(error.value)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(UserError, match="there is no such file"):
        read_fit(tmp_path)


def entry(low: float | None, high: float | None, error: float | None = 0.1, value: float = 2.0) -> dict:
    return {"value": value, "low": low, "high": high, "standard_error": error}


@pytest.mark.parametrize(
    ("given", "assumed", "ratio", "errors", "inside", "remark"),
    [
        (entry(1.8, 2.2), 1.0, 2.0, 10.0, False, "differs"),
        (entry(1.8, 2.2), 2.1, 2.0 / 2.1, -1.0, True, "agrees"),
        (entry(None, 2.2), 3.0, 2.0 / 3.0, -10.0, False, "bounded only above, differs"),
        (entry(None, 2.2), 0.0, None, 20.0, True, "bounded only above, agrees"),
        (entry(1.8, None, None), 9.0, 2.0 / 9.0, None, True, "bounded only below, agrees"),
        (entry(None, None, None), 1.0, 2.0, None, None, "not bounded by these records"),
        (entry(1.8, 2.2), None, None, None, None, ""),
    ],
)
def test_against_the_assumed_value(given, assumed, ratio, errors, inside, remark):
    found = against(given, assumed)
    assert found["ratio"] == pytest.approx(ratio) and found["standard_errors"] == pytest.approx(errors)
    assert (found["inside"], found["remark"], found["assumed"]) == (inside, remark, assumed)
    assert found["value"] == 2.0


@pytest.mark.parametrize(
    ("value", "spread", "text"),
    [
        (99295.2849, 17.1, "99295"),
        (1.0498392, 0.00147, "1.0498"),
        (0.00052, 0.006, "0.00052"),
        (120006.2, 3900.0, "120000"),
        (6.42, None, "6.420"),
        (1.23456e9, 1e5, "1.23456e+09"),
        (0.0, 1.0, "0"),
        (None, 1.0, "-"),
    ],
)
def test_figures_follow_the_spread(value, spread, text):
    assert figures(value, spread) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (149000.0, "149000"),
        (1.49, "1.49"),
        (0.003, "0.003"),
        (5.0, "5"),
        (None, "-"),
        (0.0, "0"),
        (3e9, "3e+09"),
    ],
)
def test_stated_numbers_keep_their_look(value, text):
    assert stated(value) == text


@pytest.mark.parametrize("disagree", [False, True])
def test_runs_that_disagree_are_said_to(content, fitted, tiny, disagree):
    """In the file, and in the summary."""
    saved = fit_content(dataclasses.replace(fitted, runs_disagree=disagree), tiny)
    assert saved["runs_disagree"] is disagree
    said: list[str] = []
    terminal: Any = SimpleNamespace(table=lambda *_: None, say=said.append)
    show_fit({**content, "runs_disagree": saved["runs_disagree"]}, terminal)
    assert any(sentence.startswith("The runs differ in what they say") for sentence in said) is disagree
