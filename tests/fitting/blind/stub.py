"""Sets of cases and diagnoses that are made up, so that running and scoring are tested without either."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fitting.blind.menu import FAMILIES, aliases
from fitting.blind.seal import checksums, seal
from fitting.blind_run.case_work import Outcome
from fitting.blind_run.results import Results, data_checksum
from fitting.blind_score.judged import Judged
from fitting.blind_score.score import judge_case
from jaxstick.output import to_json

CALLS = "calls.txt"
"""Where the stand-in for a diagnosis notes its cases, beside the set."""

RECIPE = {
    "physics": {"against_base": 0.0, "stiffness": 4e3, "drive_stiffness": 4e3, "drive_damping": 0.0},
    "base": None,
    "stated": {"noise": {}, "frequency": True},
}
"""What the scoring reads of a recipe."""

ANSWERS = ("none", "unlisted", *FAMILIES)
CONSTANTS = {"A": 1.0, "B": 100.0, "C": 6.0, "D": 0.5, "k1": 1e5}


def made_set(folder: Path, key: str, answers: Sequence[Mapping[str, Any]]) -> list[str]:
    """A sealed set with these answers, its records a few bytes each; the names of its cases."""
    files = {}
    for number in range(1, len(answers) + 1):
        case = folder / f"case-{number:04d}"
        case.mkdir(parents=True)
        (case / "rig.toml").write_text(f"[rig]\nmass_kg = {number}.0\n")
        (case / "run-01.csv").write_text("time_s,displacement_mm,friction_n\n0,1,2\n1,2,3\n2,3,4\n")
        files[case.name] = checksums(case)
    about = {"version": "0", "family": "judging", "seed_sha256": "ab", "failed": []}
    seal(folder, key, dict(zip(files, answers, strict=True)), files, about)
    return list(files)


def answer(
    kind: str, *keys: str, tier: str = "A", gap: float = 10.0, limit: float | None = 4.0, **parameters: Any
) -> dict[str, Any]:
    """The sealed answer of a case; parameters: value and unit by name, of the first effect."""
    listed = [key for key in keys if key in FAMILIES]
    return {
        "kind": kind,
        "tier": tier,
        "truth": {"none": ["none"], "unlisted": ["unlisted"]}.get(kind, list(keys)),
        "families": [FAMILIES[key] for key in listed],
        "aliases": {key: list(aliases(key)) for key in listed},
        "unlisted": list(keys) if kind == "unlisted" else [],
        "strength": "strong",
        "effects": {
            key: {
                "parameters": {name: {"value": value, "unit": unit} for name, (value, unit) in named.items()},
                "limit_ratio": limit,
            }
            for key, named in zip(keys, (parameters, {}), strict=False)
        },
        "gap_ratio": gap if keys else 0.0,
        "constants": CONSTANTS,
        "recipe": RECIPE,
    }


def content(
    verdict: str, *named: str, checksum: str = "", p: Mapping[str, float] | None = None, **other: Any
) -> dict[str, Any]:
    """What diagnosis.json of a case could hold; p: probabilities, the rest of 1 evenly over the others."""
    likely = dict(p or {key: 0.9 / len(named) for key in named} or {verdict: 0.9})
    rest = [key for key in ANSWERS if key not in likely]
    spread = dict.fromkeys(rest, (1 - sum(likely.values())) / len(rest))
    return {
        "schema": 1,
        "verdict": verdict,
        "named": list(named),
        "probabilities": {**likely, **spread},
        "where": {"excess": 9.0, "significance": 20.0},
        "gap": {
            "before": 5.0,
            "floor": 1.0,
            "closed": 0.99,
            "closed_interval": [0.97, 1.01],
            "placebo_closed": 0.01,
            "best_wrong_closed": 0.4,
        },
        "effects": {key: {"parameters": {}} for key in named},
        "constants": {},
        "constants_before": {},
        "candidates": [],
        "seconds": 12.0,
        "data": {"sha256": checksum},
        **other,
    }


def judged(truth: Mapping[str, Any], result: Mapping[str, Any] | None, case: str = "case-0001") -> Judged:
    """A case beside its made-up diagnosis."""
    return judge_case(case, truth, result, samples=1000)


def keep(results: Results, folder: Path, case: str, made_up: Mapping[str, Any]) -> None:
    """Puts a made-up diagnosis, with the case's checksum in it, among the results."""
    checksum = data_checksum(checksums(folder / case))
    results.keep(case, to_json({**made_up, "data": {"sha256": checksum}}))


def diagnosed(folder: Path, seed: int) -> Outcome:
    """Stands for a diagnosis: notes the case, finds no effect."""
    with (folder.parent.parent / CALLS).open("a") as stream:
        stream.write(f"{folder.name} {seed} {os.environ.get('NPROC')}\n")
    return Outcome(to_json(content("none", checksum=data_checksum(checksums(folder)))), None)


def failing_in_two(folder: Path, seed: int) -> Outcome:
    """The same, but the second case cannot be diagnosed, the third kills its process, and the fourth gets the
    diagnosis of other data."""
    if folder.name == "case-0002":
        return Outcome(None, "The motion was lost.")
    if folder.name == "case-0003":
        os.kill(os.getpid(), signal.SIGKILL)
    if folder.name == "case-0004":
        return Outcome(to_json(content("none", checksum="of other data")), None)
    return diagnosed(folder, seed)


def calls(folder: Path) -> list[str]:
    """The cases that the stand-in was asked for."""
    path = folder.parent / CALLS
    return [line.split()[0] for line in path.read_text().splitlines()] if path.exists() else []


def named_by_process(folder: Path, seed: int) -> Outcome:
    """Stands for a diagnosis that says which process made it."""
    return Outcome(str(os.getpid()), None)
