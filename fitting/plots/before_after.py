"""A run before and after: measured, the fitted nominal model, the model with the named effects."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fitting.diagnosis.findings import Trace
from jaxstick.plots.style import (
    ASSUMED,
    BAND,
    FITTED,
    HALO,
    Margins,
    framed,
    legend_above,
    length_unit,
    new_figure,
    span,
    style,
    thinned,
)

BEFORE, AFTER = ASSUMED, FITTED
CYCLES = 2.0
WINDOW_SAMPLES = 1000
MOST_MARKERS = 350
MOST_COLUMNS = 300
MARGINS = Margins(left=0.75, right=0.12, bottom=0.48, top=0.3, across=0.8, down=0.75)
"""Numbers on the axes have at most six characters, in units that make them so."""


def before_after(trace: Trace, frequency: float | None) -> Figure:
    """Above displacement and friction force over two cycles of the drive, where the nominal model misses
    most; below what both models leave of the whole run. Without a `frequency` [Hz] 1000 samples are shown."""
    shown = worst_window(trace, frequency)
    with style():
        figure = new_figure(11.0, 6.0)
        panels = figure.subplots(2, 2)
        displacement(panels[0][0], trace, shown)
        friction(panels[0][1], trace, shown)
        displacement_left(panels[1][0], trace)
        if trace.friction is None:
            panels[1][1].set_visible(False)
        else:
            friction_left(panels[1][1], trace)
        legend_above(panels[0][1])
        legend_above(panels[1][0])
        panels[0][0].set_title(trace.file + (", held out" if trace.held_out else ""))
        framed(figure, MARGINS, columns=2, rows=2)
    return figure


def worst_window(trace: Trace, frequency: float | None) -> slice:
    """The samples of those two cycles (1000 samples without a frequency) in which the nominal model misses
    most, whole run where it is shorter."""
    samples = len(trace.time)
    interval = float(trace.time[-1] - trace.time[0]) / (samples - 1)
    length = WINDOW_SAMPLES if frequency is None else round(CYCLES / (frequency * interval)) + 1
    if length >= samples:
        return slice(0, samples)
    missed = ((trace.displacement - trace.before_displacement) / trace.displacement_noise) ** 2
    if trace.friction is not None and trace.friction_noise:
        missed = missed + ((trace.friction - trace.before_friction) / trace.friction_noise) ** 2
    total = np.concatenate([[0.0], np.cumsum(np.nan_to_num(missed))])
    first = int(np.argmax(total[length:] - total[:-length]))
    return slice(first, first + length)


def displacement(axes: Axes, trace: Trace, shown: slice) -> None:
    """The displacement over time."""
    factor, unit = length_unit(span(trace.displacement))
    measured, before, after = (
        factor * values[shown]
        for values in (trace.displacement, trace.before_displacement, trace.after_displacement)
    )
    _curves(axes, trace.time[shown], measured, before, after)
    axes.set_ylabel(f"displacement x [{unit}]")


def friction(axes: Axes, trace: Trace, shown: slice) -> None:
    """The friction force over time."""
    measured = None if trace.friction is None else trace.friction[shown]
    _curves(axes, trace.time[shown], measured, trace.before_friction[shown], trace.after_friction[shown])
    axes.set_ylabel("friction force F [N]")


def displacement_left(axes: Axes, trace: Trace) -> None:
    """Measured less modelled displacement over the whole run."""
    before = trace.displacement - trace.before_displacement
    after = trace.displacement - trace.after_displacement
    factor, unit = length_unit(_size(before, trace.displacement_noise))
    _left(axes, trace.time, factor * before, factor * after, factor * trace.displacement_noise)
    axes.set_ylabel(f"x, measured - model [{unit}]")


def friction_left(axes: Axes, trace: Trace) -> None:
    """Measured less modelled friction force over the whole run, of a run that has it recorded."""
    assert trace.friction is not None
    before, after = trace.friction - trace.before_friction, trace.friction - trace.after_friction
    noise = trace.friction_noise or 0.0
    factor, unit = force_unit(_size(before, noise))
    _left(axes, trace.time, factor * before, factor * after, factor * noise)
    axes.set_ylabel(f"F, measured - model [{unit}]")


def force_unit(size: float) -> tuple[float, str]:
    """A unit in which forces of this size [N] are read easily: how many of it are a newton, and its name."""
    return (1.0, "N") if size >= 0.5 else (1e3, "mN")


def _size(left: np.ndarray, noise: float) -> float:
    return max(3 * noise, span(left))


def _curves(
    axes: Axes, time: np.ndarray, measured: np.ndarray | None, before: np.ndarray, after: np.ndarray
) -> None:
    if measured is not None:
        few = thinned(len(time), MOST_MARKERS)
        axes.plot(time[few], measured[few], "o", color=HALO, ms=3.6, mew=0, label="measured")
    axes.plot(time, before, color=BEFORE, lw=1.1, ls=(0, (5, 2)), label="nominal, fitted")
    if not np.array_equal(before, after):
        axes.plot(time, after, color=AFTER, lw=1.1, label="with the effect")
    axes.set_xlabel("time [s]")
    axes.margins(x=0.01)


def _left(axes: Axes, time: np.ndarray, before: np.ndarray, after: np.ndarray, noise: float) -> None:
    """Both residuals as the range within each of 300 stretches of the run, so that no extreme is lost."""
    edges = np.unique(np.linspace(0, len(time), MOST_COLUMNS + 1).astype(int)[:-1])
    ends = np.append(time[edges], time[-1])
    axes.axhspan(-2 * noise, 2 * noise, color=BAND, alpha=0.35, lw=0, zorder=0.5, label="2 sd of the noise")
    models = [(before, BEFORE, "nominal, fitted")]
    if not np.array_equal(before, after):
        models.append((after, AFTER, "with the effect"))
    for left, colour, label in models:
        low, high = np.minimum.reduceat(left, edges), np.maximum.reduceat(left, edges)
        axes.fill_between(
            ends,
            np.append(low, low[-1]),
            np.append(high, high[-1]),
            color=colour,
            alpha=0.85,
            lw=0.4,
            step="post",
            label=label,
        )
    axes.set_xlabel("time [s]")
    axes.margins(x=0.01)
    reach = max(4.5 * noise, 1.08 * max(span(before), span(after)))
    if reach > 0:
        axes.set_ylim(-reach, reach)
