"""The blind check in one command, with a stand-in for the diagnosis."""

from __future__ import annotations

import hashlib
import json

import pytest
from click.testing import CliRunner

from fitting.blind_run import running
from jaxstick.errors import UserError
from jaxstick.output import to_json
from scripts.blind_study import main
from tests.fitting.blind import stub


def test_it_makes_runs_scores_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.setenv("JAXSTICK_CACHE", "off")
    monkeypatch.setattr(running, "diagnose_folder", stub.diagnosed)
    out = tmp_path / "blind"
    words = ["--cases", "2", "--kind", "none", "--runs", "2", "--samples", "600", "--workers", "1"]
    done = CliRunner().invoke(main, [*words, "--seed", "4", "--out", str(out)])
    assert done.exit_code == 0, done.output
    found = json.loads((out / "score" / "score.json").read_text())
    assert found["tiers"]["all"]["none_called"]["hits"] == 2
    assert found["set"]["family"] == "judging"
    listed = json.loads((out / "cases" / "manifest.json").read_text())["cases"]
    assert found["set"]["cases_sha256"] == hashlib.sha256(to_json(listed).encode()).hexdigest()
    again = CliRunner().invoke(main, [*words, "--seed", "4", "--out", str(out)])
    assert again.exit_code == 0
    assert len(stub.calls(out / "cases")) == 2
    other = CliRunner().invoke(main, [*words, "--seed", "5", "--out", str(out)])
    assert isinstance(other.exception, UserError) and "another seed" in str(other.exception)
    wrong = CliRunner().invoke(
        main, [*words[:2], "--kind", "two", "--seed", "4", "--out", str(tmp_path / "x")]
    )
    assert isinstance(wrong.exception, UserError)
    with pytest.raises(FileNotFoundError):
        (tmp_path / "x" / "cases" / "manifest.json").read_text()
