"""jaxstick compare: identified constants against assumed ones."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from fitting.saved import SavedFit, read_fit
from fitting.show import show_comparison
from jaxstick.command import common
from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.outcome import Outcome
from jaxstick.record import DataSet, RigSheet, load_dataset, load_rig
from jaxstick.terminal import Terminal
from jaxstick.version import version

run_compare = deferred("fitting.compare", "compare")


@click.command()
@click.argument("fit", metavar="FIT.json", type=click.Path(path_type=Path))
@click.argument("source", metavar="[DATASET|RIG.toml]", required=False, type=click.Path(path_type=Path))
@common
def compare(fit: Path, source: Path | None, terminal: Terminal) -> None:
    """Set the identified constants of FIT.json against the assumed ones.

    Says how far apart they are, and how amplitude and stops of every run change with them, together and one
    by one. Rig, runs and assumed constants are those of the fitted data set, or of the one given.
    """
    saved = read_fit(fit)
    given = None if source is None else _given(source)
    comparison = _content(saved, run_compare(saved, given), given)
    show_comparison(comparison, terminal)
    terminal.result(comparison)


def _given(source: Path) -> DataSet | RigSheet:
    sheet = load_rig(source)
    if not sheet.runs:
        raise UserError(f"{sheet.path}: no run is listed, so there is no motion to compare.")
    if source.is_dir() and any((source / plan.file).exists() for plan in sheet.runs):
        return load_dataset(source)
    return sheet


def _content(saved: SavedFit, found: Any, given: DataSet | RigSheet | None) -> dict[str, Any]:
    return {
        "schema": 1,
        "fit_outcome": saved.content["outcome"],
        "constants": found.constants,
        "others": found.others,
        "runs": [
            {
                "file": run.file,
                "frequency_hz": run.cycle.frequency,
                "frequency_ratio": run.cycle.frequency / run.natural_frequency
                if run.natural_frequency
                else None,
                "base_amplitude_m": run.cycle.base_amplitude,
                "force_amplitude_n": run.cycle.force_amplitude,
                "measured": _outcome(run.measured),
                "assumed": _outcome(run.assumed),
                "identified": _outcome(run.identified),
                "exchanged": None
                if run.exchanged is None
                else {name: _outcome(outcome) for name, outcome in run.exchanged.items()},
            }
            for run in found.runs
        ],
        "notices": list(found.notices),
        "data": {
            "fitted": saved.content["data"]["sha256"],
            "compared": None if given is None else given.sha256,
        },
        "version": version(),
    }


def _outcome(outcome: Outcome | None) -> dict[str, Any] | None:
    if outcome is None:
        return None
    entry = asdict(outcome)
    return {"amplitude_m": entry.pop("amplitude"), **entry}
