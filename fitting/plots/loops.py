"""Friction loops: the friction force over the way slid, measured and fitted."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure

from fitting.result import Trace
from jaxstick.cycle import cycle_of
from jaxstick.plots.style import FITTED, HALO, length_unit, new_figure, span, style, thinned

COLUMNS = 3
MOST_PANELS = 12
CYCLES = 2.0


def loops(traces: Sequence[Trace]) -> Figure:
    """The last two cycles of every run, one panel each (the first twelve runs where there are more)."""
    chosen = traces[:MOST_PANELS]
    columns = min(COLUMNS, len(chosen))
    rows = math.ceil(len(chosen) / columns)
    with style():
        figure = new_figure(3.6 * columns + 0.4, 2.9 * rows + 0.4)
        panels = figure.subplots(rows, columns, squeeze=False, sharey=True).ravel()
        for axes, trace in zip(panels, chosen, strict=False):
            run = trace.run
            cycle = cycle_of(run)
            samples = len(run.time) if cycle is None else round(CYCLES / (cycle.frequency * run.interval)) + 1
            shown = slice(-min(samples, len(run.time)), None)
            measured, fitted = (x - trace.guide for x in (run.displacement, trace.displacement))
            factor, unit = length_unit(span(measured))
            if run.friction is not None:
                few = thinned(len(run.time[shown]))
                axes.plot(
                    factor * measured[shown][few],
                    run.friction[shown][few],
                    ".",
                    color=HALO,
                    ms=6.0,
                    mew=0,
                    label="measured",
                )
            axes.plot(
                factor * fitted[shown],
                trace.friction[shown],
                color=FITTED,
                lw=0.9,
                label="fitted",
            )
            axes.set_title(run.file if cycle is None else f"{run.file}, {cycle.frequency:.4g} Hz")
            axes.set_xlabel(f"displacement over the guide [{unit}]")
        for axes in panels[::columns]:
            axes.set_ylabel("friction force F [N]")
        for axes in panels[len(chosen) :]:
            axes.set_visible(False)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=2)
    return figure
