"""A few sealed cases, made, diagnosed and scored as a whole: the guard against a diagnosis that gets worse.

The cases are always the same; what is asked for is how many are right, not which answer each gets.
"""

from __future__ import annotations

import pytest

from fitting.blind.case import Settings
from fitting.blind.making import make_cases
from fitting.blind.rigs import Size
from fitting.blind.seal import new_key, read_manifest
from fitting.blind_run.case_work import diagnose_folder
from fitting.blind_run.results import Results
from fitting.blind_score.score import judged_cases
from fitting.progress import Silent

CASES, ENOUGH = 4, 3
SEED = 20261123


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """The cases with their answers and diagnoses."""
    folder, key = tmp_path_factory.mktemp("fixed"), new_key()
    settings = Settings("development", SEED, Size(runs=4, samples=1600))
    sealed, results = folder / "cases", Results(folder / "results")
    make_cases(sealed, CASES, settings, key, Silent(), kinds=("none", "single"), tiers=("A",), workers=1)
    manifest = read_manifest(sealed)
    results.begin(manifest, 0, overwrite=False)
    for case in manifest["cases"]:
        found = diagnose_folder(sealed / case, 0)
        assert found.diagnosis is not None, found.failure
        results.keep(case, found.diagnosis)
    cases, missing, _ = judged_cases(sealed, results.folder, key)
    assert len(cases) == CASES and not missing
    return cases


def test_most_of_them_are_right(judged):
    right = [case.case for case in judged if case.right()]
    assert len(right) >= ENOUGH, {case.case: (case.truth, case.result["named"]) for case in judged}


def test_what_is_named_closes_the_gap(judged):
    shares = [case.result["gap"]["closed"] for case in judged if case.kind == "single" and case.right()]
    assert shares and min(shares) > 0.5
