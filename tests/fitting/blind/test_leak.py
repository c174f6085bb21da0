"""Nothing beside the samples themselves tells what a case holds.

A classifier sees everything of a case but the samples: names, order, sizes, digits, units, which keys and
channels there are, the stated numbers. It may not tell the kinds or families of effects apart better than it
does with labels in random order.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from fitting.blind.making import make_cases
from fitting.blind.seal import new_key, open_seal
from fitting.progress import Silent
from tests.fitting.blind.small import SETTINGS

CASES = 152
FOLDS = 8
SHUFFLES = 200
LEVEL = 0.01


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    """The features of every case and its answer."""
    folder, key = tmp_path_factory.mktemp("leak") / "cases", new_key()
    made = make_cases(folder, CASES, SETTINGS, key, Silent(), workers=1)
    assert made.failed == {}
    answers = open_seal(folder, key).answers
    table = [metadata(folder / name, number) for number, name in enumerate(answers)]
    names = sorted({name for row in table for name in row})
    features = np.array([[row.get(name, 0.0) for name in names] for row in table])
    return features, list(answers.values())


def metadata(case: Path, number: int) -> dict[str, float]:
    """Everything of a case but its samples, as numbers by name."""
    found: dict[str, float] = {"number": float(number)}
    files = sorted(case.iterdir())
    found["files"] = float(len(files))
    for path in files:
        found[f"name {path.name}"] = 1.0
        found[f"size {path.name}"] = float(path.stat().st_size)
        lines = path.read_text().splitlines()
        found[f"lines {path.name}"] = float(len(lines))
        found[f"comments {path.name}"] = float(sum(line.startswith("#") for line in lines))
        if path.suffix == ".csv":
            for place, name in enumerate(lines[0].split(",")):
                cells = [line.split(",")[place] for line in lines[1:]]
                assert len({len(cell) for cell in cells}) == 1
                found[f"width {place}"] = float(len(cells[0]))
                found[f"decimals {place}"] = float(len(cells[0].partition(".")[2]))
                found[f"column {name}"] = 1.0
    text = (case / "rig.toml").read_text()
    found["digits"] = float(len(re.findall(r"\d", text)))
    rig = tomllib.loads(text)
    for section in ("rig", "assumed", "noise"):
        for key, value in rig.get(section, {}).items():
            found[f"{section} {key}"] = np.log(value + 1e-9) if isinstance(value, float) else len(value)
    for run in rig["run"]:
        for key, value in run.items():
            found[f"run {key}"] = float(value) if isinstance(value, float) else 1.0
    return found


def accuracy(features: np.ndarray, labels: np.ndarray) -> float:
    """Share of cases that a ridge classifier names rightly, each in the fold that it was not trained on."""
    spread = features.std(axis=0)
    scaled = (features[:, spread > 0] - features[:, spread > 0].mean(axis=0)) / spread[spread > 0]
    scaled = np.concatenate((scaled, np.ones((len(scaled), 1))), axis=1)
    wanted = (labels[:, None] == np.unique(labels)).astype(float)
    right = 0
    for fold in range(FOLDS):
        test = np.arange(len(labels)) % FOLDS == fold
        known = scaled[~test]
        weights = np.linalg.solve(known.T @ known + 10.0 * np.eye(known.shape[1]), known.T @ wanted[~test])
        right += int((np.argmax(scaled[test] @ weights, axis=1) == np.argmax(wanted[test], axis=1)).sum())
    return right / len(labels)


def significance(features: np.ndarray, labels: np.ndarray) -> float:
    """How often labels in random order are named as well."""
    random = np.random.default_rng(0)
    reached = accuracy(features, labels)
    chance = [accuracy(features, random.permutation(labels)) for _ in range(SHUFFLES)]
    return (1 + sum(one >= reached for one in chance)) / (SHUFFLES + 1)


def labelled(answers, question: str) -> np.ndarray:
    """What each case holds, in the words of a question."""
    if question == "kind":
        return np.array([answer["kind"] for answer in answers])
    if question == "effect or none":
        return np.array([answer["kind"] == "none" for answer in answers])
    return np.array(["+".join(sorted(set(answer["families"]))) or answer["kind"] for answer in answers])


@pytest.mark.parametrize("question", ["kind", "effect or none", "family"])
def test_metadata_tells_nothing(cases, question):
    features, answers = cases
    assert significance(features, labelled(answers, question)) > LEVEL


def test_a_planted_leak_is_found(cases):
    features, answers = cases
    labels = labelled(answers, "kind")
    hint = (labels == "single") + np.random.default_rng(1).normal(0.0, 0.7, len(labels))
    assert significance(np.column_stack((features, hint)), labels) <= LEVEL
