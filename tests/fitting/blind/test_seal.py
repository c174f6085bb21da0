"""The seal: it opens with its key and tells what is wrong otherwise, in one sentence."""

from __future__ import annotations

import json

import pytest

from fitting.blind.journal import Journal
from fitting.blind.seal import MANIFEST, SEALED, checksums, new_key, open_seal, seal
from jaxstick.errors import UserError

ANSWERS = {"case-0001": {"truth": ["none"]}, "case-0002": {"truth": ["force_gain"]}}


@pytest.fixture
def sealed(tmp_path):
    key = new_key()
    for name in ANSWERS:
        (tmp_path / name).mkdir()
        (tmp_path / name / "rig.toml").write_text(f"# {name}\n")
    files = {name: checksums(tmp_path / name) for name in ANSWERS}
    seal(tmp_path, key, ANSWERS, files, {"family": "development"})
    return tmp_path, key


def refusal(folder, key) -> str:
    with pytest.raises(UserError) as caught:
        open_seal(folder, key)
    sentence = str(caught.value)
    assert sentence.endswith(".") and "\n" not in sentence
    return sentence


def test_the_key_opens_it(sealed):
    folder, key = sealed
    opened = open_seal(folder, key)
    assert opened.answers == ANSWERS
    assert opened.manifest["family"] == "development"
    for path in folder.rglob("*"):
        if path.is_file():
            assert b"force_gain" not in path.read_bytes()


def test_another_key_does_not(sealed):
    folder, _ = sealed
    assert "another" in refusal(folder, new_key())
    assert "44 characters" in refusal(folder, "open sesame")


def test_a_changed_seal_is_noticed(sealed):
    folder, key = sealed
    path = folder / SEALED
    path.write_bytes(path.read_bytes()[:-3] + b"abc")
    assert "sealed answers were changed" in refusal(folder, key)
    path.unlink()
    assert "missing" in refusal(folder, key)


def test_a_changed_or_missing_case_is_noticed(sealed):
    folder, key = sealed
    path = folder / "case-0002" / "rig.toml"
    path.write_text("# other\n")
    assert "was changed" in refusal(folder, key)
    path.unlink()
    assert "the file is missing" in refusal(folder, key)
    path.parent.rmdir()
    assert "the case is missing" in refusal(folder, key)


def test_what_is_no_set_of_cases_is_said(tmp_path):
    assert MANIFEST in refusal(tmp_path, new_key())
    (tmp_path / MANIFEST).write_text(json.dumps({"schema": 1}))
    assert "not the manifest" in refusal(tmp_path, new_key())


def test_a_journal_keeps_what_was_done(tmp_path):
    key, plan = new_key(), {"seed": 1}
    Journal(tmp_path, key, plan).add("case-0001", {"answer": 1})
    with (tmp_path / "answers.partial").open("ab") as stream:
        stream.write(b"half a li")
    journal = Journal(tmp_path, key, plan)
    assert journal.entries == {"case-0001": {"answer": 1}}
    journal.add("case-0002", {"answer": 2})
    assert set(Journal(tmp_path, key, plan).entries) == {"case-0001", "case-0002"}
    with pytest.raises(UserError, match="another seed"):
        Journal(tmp_path, key, {"seed": 2})
    with pytest.raises(UserError, match="another"):
        Journal(tmp_path, new_key(), plan)
