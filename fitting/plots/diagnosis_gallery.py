"""All figures of a diagnosis, drawn and saved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import PurePosixPath

from matplotlib.figure import Figure

from fitting.diagnosis.findings import Diagnosis, Trace
from fitting.plots.before_after import before_after
from fitting.plots.probabilities import probabilities
from fitting.plots.residual_force import residual_force
from fitting.progress import Progress
from jaxstick.cycle import cycle_of
from jaxstick.output import OutputFolder
from jaxstick.plots.style import save
from jaxstick.record import DataSet


def draw_diagnosis(diagnosis: Diagnosis, dataset: DataSet, output: OutputFolder, progress: Progress) -> None:
    """Writes plots/*.png: the probabilities, the residual force, and for each run its traces."""
    figures = list(_figures(diagnosis, frequencies(dataset)))
    progress.stage("plots", len(figures))
    for name, draw in figures:
        save(draw(), output.path(f"plots/{name}.png"))
        progress.advance(name)


def frequencies(dataset: DataSet) -> dict[str, float | None]:
    """The frequency of each run's drive [Hz] by file; None where it is not one sine."""
    cycles = {run.file: cycle_of(run) for run in dataset.runs}
    return {file: None if cycle is None else cycle.frequency for file, cycle in cycles.items()}


def worst_first(diagnosis: Diagnosis) -> list[Trace]:
    """The traces, those first whose runs hold most of the excess; runs of no share last, as they come."""
    share = diagnosis.where.run
    return sorted(diagnosis.traces, key=lambda trace: -share.get(trace.file, 0.0))


def worst_residual_run(diagnosis: Diagnosis) -> tuple[int, str]:
    """Number and file of the run with the largest share of the excess among those whose residual force is
    known."""
    known = set(diagnosis.residual_force.run.tolist())
    numbers = {trace.file: number for number, trace in enumerate(diagnosis.traces) if number in known}
    file = next((trace.file for trace in worst_first(diagnosis) if trace.file in numbers), "")
    return numbers.get(file, 0), file


def _figures(
    diagnosis: Diagnosis, frequency: Mapping[str, float | None]
) -> Iterator[tuple[str, Callable[[], Figure]]]:
    yield "probabilities", lambda: probabilities(diagnosis)
    if len(diagnosis.residual_force.force):
        yield (
            "residual-force",
            lambda: residual_force(diagnosis.residual_force, *worst_residual_run(diagnosis)),
        )
    for trace in worst_first(diagnosis):
        name = PurePosixPath(trace.file).with_suffix("")
        yield f"{name}-before-after", lambda trace=trace: before_after(trace, frequency.get(trace.file))
