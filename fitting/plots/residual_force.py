"""The force that the fitted nominal model lacks, over velocity, place and time: what an expert reads an
effect from."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from fitting.diagnosis.findings import ResidualForce
from fitting.plots.before_after import force_unit
from jaxstick.plots.style import FITTED, HALO, MEASURED, SERIES, length_unit, new_figure, span, style, thinned

FORWARD, BACKWARD, AT_REST = FITTED, SERIES[1], SERIES[3]
DIVERGING = (
    "#00507d",
    "#3a8dbf",
    "#8dbfdf",
    "#cfe3f0",
    "#f1f1ef",
    "#f8dcc9",
    "#f0ae83",
    "#dd7433",
    "#a14600",
)
"""From a force against the positive direction to one along it."""
MOST_POINTS = 5000
BINS = 18
PLANE_BINS = (26, 18)
FEWEST_IN_BIN = 3
TIME_COLUMNS = 300
MOST_OF_IT = 0.9
"""The share of the samples, and of the medians drawn, that axes and colours are wide enough for."""


def residual_force(found: ResidualForce, run: int, file: str) -> Figure:
    """Four panels: over velocity, over displacement, over the plane of both, and over time of one run."""
    with style():
        figure = new_figure(11.0, 7.0)
        panels = figure.subplots(2, 2)
        over_velocity(panels[0][0], found)
        over_displacement(panels[0][1], found)
        over_plane(panels[1][0], found)
        over_time(panels[1][1], found, run)
        panels[0][0].set_title("over velocity: median and middle half")
        panels[0][1].set_title("over displacement, by direction")
        panels[1][0].set_title("over displacement and velocity: median of each cell")
        panels[1][1].set_title(f"over time, {file}")
    return figure


def over_velocity(axes: Axes, found: ResidualForce) -> None:
    """Every sample, and the median with the quartiles in bins of velocity, at rest left out."""
    found = _known(found)
    moving = ~found.at_rest
    factor, unit = length_unit(span(found.slide_rate))
    force, force_name = _scaled(found)
    few = thinned(len(force), MOST_POINTS)
    axes.plot(
        factor * found.slide_rate[few],
        force[few],
        ".",
        color=HALO,
        ms=2.0,
        mew=0,
        alpha=0.5,
        rasterized=True,
    )
    drawn = [
        _median_line(axes, factor * found.slide_rate[own], force[own], colour, label)
        for own, colour, label in (
            (moving & (found.slide_rate > 0), FORWARD, "forward"),
            (moving & (found.slide_rate < 0), BACKWARD, "backward"),
        )
    ]
    _frame(axes, force, np.concatenate(drawn), force_name)
    axes.set_xlabel(f"sliding velocity [{unit}/s]")
    _legend(axes)


def over_displacement(axes: Axes, found: ResidualForce) -> None:
    """The median with the quartiles in bins of displacement: sliding forward, backward, and at rest."""
    found = _known(found)
    factor, unit = length_unit(span(found.displacement))
    force, force_name = _scaled(found)
    moving = ~found.at_rest
    drawn = [
        _median_line(axes, factor * found.displacement[own], force[own], colour, label)
        for own, colour, label in (
            (found.at_rest, AT_REST, "at rest"),
            (moving & (found.slide_rate > 0), FORWARD, "forward"),
            (moving & (found.slide_rate < 0), BACKWARD, "backward"),
        )
    ]
    _frame(axes, force, np.concatenate(drawn[1:]), force_name)
    axes.set_xlabel(f"displacement x [{unit}]")
    _legend(axes)


def over_plane(axes: Axes, found: ResidualForce) -> None:
    """The median in each cell of the plane of displacement and velocity, as colour in nine steps."""
    found = _known(found)
    x_factor, x_unit = length_unit(span(found.displacement))
    v_factor, v_unit = length_unit(span(found.slide_rate))
    force, force_name = _scaled(found)
    plane = _plane(x_factor * found.displacement, v_factor * found.slide_rate, force)
    reach = _reach(plane.values, 0.98) or 1.0
    edges = reach * np.linspace(-1, 1, len(DIVERGING) + 1)
    colours = ListedColormap(DIVERGING)
    cells = PolyCollection(
        list(plane.corners),
        array=np.clip(plane.values, edges[0], edges[-1] * (1 - 1e-9)),
        cmap=colours,
        norm=BoundaryNorm(edges.tolist(), len(DIVERGING)),
        edgecolors="none",
    )
    axes.add_collection(cells)
    axes.autoscale_view()
    axes.margins(0.03)
    axes.set_xlabel(f"displacement x [{x_unit}]")
    axes.set_ylabel(f"sliding velocity [{v_unit}/s]")
    bar = axes.figure.colorbar(cells, ax=axes, ticks=[-reach, 0.0, reach], format="%.2g", aspect=26, pad=0.02)
    bar.set_label(f"residual force [{force_name}]")
    bar.outline.set_visible(False)  # pyright: ignore[reportCallIssue]


def over_time(axes: Axes, found: ResidualForce, run: int) -> None:
    """Of one run: the middle half of the samples in each of 300 stretches, and the running median."""
    found = _known(found)
    own = found.run == run
    force, force_name = _scaled(found)
    time, force = found.time[own], force[own]
    if len(time):
        stretches = np.array_split(np.arange(len(time)), min(TIME_COLUMNS, max(1, len(time) // 3)))
        middle = np.array([time[part].mean() for part in stretches])
        low, median, high = (
            np.array([np.quantile(force[part], q) for part in stretches]) for q in (0.25, 0.5, 0.75)
        )
        axes.fill_between(middle, low, high, color=HALO, alpha=0.6, lw=0, label="middle half")
        axes.plot(middle, median, color=FITTED, lw=1.0, label="median")
    _frame(axes, force, force, force_name)
    axes.set_xlabel("time [s]")
    axes.margins(x=0.01)


def _known(found: ResidualForce) -> ResidualForce:
    """The samples of which everything is a number: a stretch that the fit lost has no residual force."""
    names = ("force", "displacement", "slide_rate", "time", "run", "at_rest")
    arrays = {name: np.asarray(getattr(found, name)) for name in names}
    kept = np.logical_and.reduce([np.isfinite(arrays[name]) for name in names])
    return dataclasses.replace(found, **{name: array[kept] for name, array in arrays.items()})


class _Plane(NamedTuple):
    corners: np.ndarray
    values: np.ndarray


def _plane(x: np.ndarray, v: np.ndarray, force: np.ndarray) -> _Plane:
    """The cells with enough samples: corners, shape (cells, 4, 2), and medians."""
    if not len(x):
        return _Plane(np.empty((0, 4, 2)), np.empty(0))
    columns, rows = PLANE_BINS
    x_edges = np.linspace(x.min(), x.max(), columns + 1)
    v_edges = np.linspace(v.min(), v.max(), rows + 1)
    column = np.clip(np.searchsorted(x_edges, x, side="right") - 1, 0, columns - 1)
    row = np.clip(np.searchsorted(v_edges, v, side="right") - 1, 0, rows - 1)
    cell = column * rows + row
    order = np.argsort(cell, kind="stable")
    numbers, firsts = np.unique(cell[order], return_index=True)
    corners, values = [], []
    for number, part in zip(numbers, np.split(force[order], firsts[1:]), strict=True):
        if len(part) >= FEWEST_IN_BIN:
            c, r = divmod(int(number), rows)
            (left, right), (low, high) = x_edges[c : c + 2], v_edges[r : r + 2]
            corners.append([(left, low), (right, low), (right, high), (left, high)])
            values.append(np.median(part))
    return _Plane(np.array(corners, float).reshape(-1, 4, 2), np.array(values, float))


def _median_line(axes: Axes, where: np.ndarray, force: np.ndarray, colour: str, label: str) -> np.ndarray:
    """Median and quartiles in bins of equal width that hold enough samples; returns the medians."""
    if len(where) < FEWEST_IN_BIN or np.ptp(where) == 0:
        return np.empty(0)
    edges = np.linspace(where.min(), where.max(), BINS + 1)
    number = np.clip(np.searchsorted(edges, where, side="right") - 1, 0, len(edges) - 2)
    rows = []
    for bin_ in range(len(edges) - 1):
        part = force[number == bin_]
        if len(part) >= FEWEST_IN_BIN:
            rows.append([edges[bin_ : bin_ + 2].mean(), *np.quantile(part, (0.25, 0.5, 0.75))])
    place, low, median, high = np.array(rows, float).reshape(-1, 4).T
    if len(place):
        axes.fill_between(place, low, high, color=colour, alpha=0.25, lw=0)
        axes.plot(place, median, color=colour, lw=1.8, label=label)
    return median


def _scaled(found: ResidualForce) -> tuple[np.ndarray, str]:
    """The force in a readable unit, and the unit."""
    factor, name = force_unit(_reach(found.force, MOST_OF_IT))
    return factor * found.force, name


def _legend(axes: Axes) -> None:
    """All labels in one row, where anything has one."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        axes.legend(handles, labels, loc="upper right", ncols=len(handles))


def _reach(values: np.ndarray, share: float) -> float:
    """The magnitude that this share of the values does not exceed; 0 of none."""
    return float(np.quantile(np.abs(values), share)) if len(values) else 0.0


def _frame(axes: Axes, force: np.ndarray, drawn: np.ndarray, unit: str) -> None:
    axes.axhline(0.0, color=MEASURED, lw=0.7, zorder=1.5)
    axes.set_ylabel(f"residual force [{unit}]")
    reach = max(1.6 * _reach(force, MOST_OF_IT), 1.4 * _reach(drawn, 0.97))
    if reach > 0:
        axes.set_ylim(-reach, reach)
