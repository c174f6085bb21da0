"""Whether the run that a diagnosis proposes tells apart what it left open: recorded, and diagnosed anew.

    python -m scripts.study_next_run ROOT

ROOT is the folder of a `scripts.blind_study` (cases/, key and results/). For every case whose diagnosis
proposes a run that would tell two explanations apart, the simulator that made the case, which shares no code
with the diagnosis, records that run too, as long as it was asked for; all runs are then diagnosed once more,
the same ones held out. Printed as a table: what acts, what was answered before and after, with the
probability of the truth, and how far the two explanations were to lie apart (3.3 is asked for). The data sets
with their added runs are kept in ROOT/next.
"""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from fitting.blind.case import settled_drive
from fitting.blind.folder import write_case
from fitting.blind.recipe import recipe_from
from fitting.blind.seal import open_seal, read_key
from fitting.diagnosis.diagnose import diagnose
from fitting.diagnosis.settings import DiagnosisSettings
from jaxstick.compilation_cache import set_up_jax
from jaxstick.record import load_dataset

SETTLING = 12
"""Cycles before the added run is recorded."""


@click.command()
@click.argument("root", type=click.Path(exists=True, path_type=Path))
def main(root: Path) -> None:
    """Record the runs that the diagnoses in ROOT propose, diagnose anew, and print a table in Markdown."""
    set_up_jax()
    click.echo("| case | what acts | before | p | to lie apart by | after | p |")
    click.echo("| --- | --- | --- | ---: | ---: | --- | ---: |")
    for name, answer in sorted(open_seal(root / "cases", read_key(root / "key")).answers.items()):
        result = root / "results" / name / "diagnosis.json"
        before = json.loads(result.read_text(encoding="utf-8")) if result.exists() else {}
        proposal = before.get("next_run")
        if not proposal or not proposal["tells_apart"]:
            continue
        folder = root / "next" / name
        with_run(answer, proposal, folder)
        settings = DiagnosisSettings(hold_out=tuple(before["gap"]["held_out"]))
        after = diagnose(load_dataset(folder), settings)
        cells = (
            name,
            ", ".join(answer["truth"]),
            _answered(before["verdict"], before["named"]),
            f"{_of_truth(answer, before['probabilities']):.2f}",
            f"{proposal['separation']:.1f}",
            _answered(after.verdict, after.named),
            f"{_of_truth(answer, after.probabilities):.2f}",
        )
        click.echo(f"| {' | '.join(cells)} |")


def with_run(answer: Mapping[str, Any], proposal: Mapping[str, Any], folder: Path) -> None:
    """Writes a case anew with the proposed run as its last; its other runs are what they were."""
    recipe = recipe_from(answer["recipe"])
    like = recipe.runs[0]
    added = dataclasses.replace(
        like,
        frequency=proposal["frequency_hz"],
        amplitude=proposal["base_amplitude_m"],
        samples=like.samples * proposal["times_as_long"],
        settling=max(like.settling, round(SETTLING / proposal["frequency_hz"] / recipe.interval)),
    )
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    write_case(settled_drive(dataclasses.replace(recipe, runs=(*recipe.runs, added))), folder)


def _answered(verdict: str, named: Sequence[str]) -> str:
    return f"{verdict}: {', '.join(named)}" if named else verdict


def _of_truth(answer: Mapping[str, Any], probabilities: Mapping[str, float]) -> float:
    """The probability of what acts; of two effects, that of the less likely."""
    return min(probabilities[key] for key in answer["truth"])


if __name__ == "__main__":
    main()
