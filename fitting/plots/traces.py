"""Displacement and friction force over time, measured and fitted."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fitting.result import Trace
from jaxstick.cycle import cycle_of
from jaxstick.plots.style import (
    ASSUMED,
    FITTED,
    FREE_RUN,
    HALO,
    legend_above,
    length_unit,
    new_figure,
    span,
    style,
    thinned,
)

CYCLES = 2.0
MOST_SAMPLES = 6000


def traces(trace: Trace) -> Figure:
    """The last two drive cycles of a run (its last 6000 samples at most): what was measured, the fit in
    pieces with a start of their own each, and the free run from the first sample. Pieces that the fit gave
    less weight are shaded."""
    run = trace.run
    cycle = cycle_of(run)
    samples = len(run.time) if cycle is None else round(CYCLES / (cycle.frequency * run.interval)) + 1
    shown = slice(-min(samples, len(run.time), MOST_SAMPLES), None)
    time = run.time[shown]
    factor, unit = length_unit(span(run.displacement))
    with style():
        figure = new_figure(10.0, 5.6)
        above, below = figure.subplots(2, 1, sharex=True)
        _curves(above, time, *(factor * values[shown] for values in _displacements(trace)))
        measured = None if run.friction is None else run.friction[shown]
        _curves(below, time, measured, trace.friction[shown], trace.free_friction[shown])
        for axes in (above, below):
            _shade(axes, trace, shown)
            axes.margins(x=0.01)
        above.set_title(run.file + (", held out" if run.hold_out else ""))
        above.set_ylabel(f"displacement x [{unit}]")
        legend_above(above)
        below.set_ylabel("friction force F [N]")
        below.set_xlabel("time [s]")
    return figure


def _displacements(trace: Trace) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return trace.run.displacement, trace.displacement, trace.free_displacement


def _curves(
    axes: Axes, time: np.ndarray, measured: np.ndarray | None, fitted: np.ndarray, free: np.ndarray
) -> None:
    if measured is not None:
        few = thinned(len(time), 2000)
        axes.plot(time[few], measured[few], ".", color=HALO, ms=7.0, mew=0, label="measured")
    axes.plot(time, free, color=FREE_RUN, lw=0.9, ls=(0, (5, 2)), label="free run")
    axes.plot(time, fitted, color=FITTED, lw=1.0, label="fitted in pieces")


def _shade(axes: Axes, trace: Trace, shown: slice) -> None:
    time = trace.run.time
    first = time[shown][0]
    ends = np.append(trace.segment_starts[1:], len(time)) - 1
    for start, end, excluded in zip(trace.segment_starts, ends, trace.excluded, strict=True):
        if excluded and time[end] > first:
            axes.axvspan(float(max(time[start], first)), float(time[end]), color=ASSUMED, alpha=0.15, lw=0)
