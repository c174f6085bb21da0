"""All figures of a fit, drawn and saved."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import PurePosixPath

from matplotlib.figure import Figure

from fitting.plots.descent import descent
from fitting.plots.friction_law import friction_law
from fitting.plots.loops import loops
from fitting.plots.residuals import residuals
from fitting.plots.traces import traces
from fitting.progress import Progress
from fitting.result import Fit
from jaxstick.output import OutputFolder
from jaxstick.plots.style import save


def draw_fit(fit: Fit, output: OutputFolder, progress: Progress) -> None:
    """Writes plots/*.png: the friction law, the friction loops, the search, and for each run its traces and
    residuals."""
    figures = list(_figures(fit))
    progress.stage("plots", len(figures))
    for name, draw in figures:
        save(draw(), output.path(f"plots/{name}.png"))
        progress.advance(name)


def _figures(fit: Fit) -> Iterator[tuple[str, Callable[[], Figure]]]:
    yield "friction-law", lambda: friction_law(fit)
    yield "loops", lambda: loops(fit.traces)
    yield "search", lambda: descent(fit)
    for trace in fit.traces:
        name = PurePosixPath(trace.run.file).with_suffix("")
        yield f"{name}-traces", lambda trace=trace: traces(trace)
        yield f"{name}-residuals", lambda trace=trace: residuals(trace, fit.gaps)
