"""Diagnosing a set of sealed cases."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fitting.blind.seal import check_cases, read_manifest
from fitting.blind_run.case_work import Outcome, diagnose_folder
from fitting.blind_run.chosen import chosen
from fitting.blind_run.processes import on_cores
from fitting.blind_run.results import Results
from fitting.progress import Progress
from jaxstick.deferred import deferred
from jaxstick.errors import UserError

on_cluster = deferred("fitting.blind_run.cluster", "on_cluster")


@dataclass(frozen=True)
class Ran:
    """What a run has done: cases asked for, how many had a diagnosis before, how many got one now, and why
    the others have none."""

    cases: int
    before: int
    new: int
    failed: Mapping[str, str]


def run_cases(
    folder: Path,
    out: Path,
    progress: Progress,
    *,
    seed: int = 0,
    workers: int | None = None,
    numbers: Sequence[int] | None = None,
    scheduler: str | None = None,
    overwrite: bool = False,
) -> Ran:
    """Diagnoses the cases of the set in `folder`, and keeps each diagnosis in the folder `out` at once.

    A case whose diagnosis is there, whole and of the same data, is not done again; one that failed before is.
    numbers: those of the cases to diagnose, all by default; workers: processes, as many as cores by default;
    scheduler: the address of a Dask scheduler whose workers diagnose instead.

    Raises:
        UserError: where the set is not whole or was changed, a number is not in it, the results folder is
            something else's, or the scheduler cannot be used.
        ClusterLostError: where the cluster fails on the way; what was finished is kept.
    """
    manifest = read_manifest(folder)
    check_cases(folder, manifest)
    _check_place(folder, out)
    if scheduler is not None and importlib.util.find_spec("distributed") is None:
        raise UserError(
            "--scheduler needs the package distributed, which is not installed here: pip install "
            "'jaxstick[cluster]'."
        )
    names = chosen(folder, manifest, numbers)
    results = Results(out)
    results.begin(manifest, seed, overwrite)
    files = manifest["cases"]
    left = {name: folder / name for name in names if results.read(name, files[name]) is None}
    progress.stage("cases", len(left))
    failed: dict[str, str] = {}
    for name, outcome in _outcomes(left, seed, workers, scheduler):
        failure = outcome.failure
        if outcome.diagnosis is not None:
            results.keep(name, outcome.diagnosis)
            if results.read(name, files[name]) is None:
                failure = "What came back is no diagnosis of this case's data."
        if failure is not None:
            results.keep_failure(name, failure)
            failed[name] = failure
        progress.advance(name)
    new = len(left) - len(failed)
    return Ran(len(names), len(names) - len(left), new, dict(sorted(failed.items())))


def _outcomes(
    left: Mapping[str, Path], seed: int, workers: int | None, scheduler: str | None
) -> Iterator[tuple[str, Outcome]]:
    if not left:
        return iter(())
    if scheduler is not None:
        return on_cluster(left, seed, scheduler)
    return on_cores(left, seed, workers or os.cpu_count() or 1, diagnose_folder)


def _check_place(folder: Path, out: Path) -> None:
    cases, results = folder.resolve(), out.resolve()
    if results == cases or cases in results.parents:
        raise UserError(f"{out}: results may not lie in the folder of the cases.")
