"""A sweep in pictures: amplitude curves with their stop regions, and maps where two axes vary."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator
from numpy.typing import NDArray

from jaxstick.output import OutputFolder
from jaxstick.plots.style import new_figure, save, style
from jaxstick.sweeps.field import Field, curves, said
from jaxstick.sweeps.plan import AXES
from jaxstick.sweeps.regions import Region, bridged, regions

MOST_CURVES = 6
"""Values of a second axis beyond which it becomes the height of a map."""

MOST_FIGURES = 12
"""Figures of a sweep over three axes or more; what would go beyond is left out."""

WIDE_RANGE = 5.0
"""The ratio of largest to smallest value from which on an axis is logarithmic."""

MANY_STOPS = 12.0
BRIGHTEST = 0.86
"""The share of the colour map that stands out from white."""

NOT_PERIODIC = "#000000"
SHADE = "#f3f3f3"
LEAST_LABELLED = 0.018
"""The share of the width from which on a region is labelled."""

RATIO_LABEL = "frequency ratio $f/f_n$"
AMPLITUDE_LABEL = "amplitude over base amplitude"


def draw_sweep(field: Field, output: OutputFolder) -> None:
    """Writes the figures of a sweep: plots/amplitude*.png, or plots/map*.png where a second axis has more
    than six values. Over further axes there is one figure for each combination, twelve at most."""
    along, across = _chosen_axes(field)
    draw, name = (amplitude_map, "map") if across is not None else (amplitude_curves, "amplitude")
    shown = [axis for axis in (across, along) if axis is not None]
    if across is None and len(field.axes) > 1:
        others = sorted(
            (axis for axis in field.axes if axis != along), key=lambda axis: -len(field.axes[axis])
        )
        shown.append(others[0])
    rest = [axis for axis in field.axes if axis not in shown]
    combinations = list(np.ndindex(*(len(field.axes[axis]) for axis in rest)))[:MOST_FIGURES]
    for number, index in enumerate(combinations, start=1):
        chosen = dict(zip(rest, index, strict=True))
        figure = draw(field.at(chosen), said(field, chosen))
        suffix = f"-{number:02d}" if len(combinations) > 1 else ""
        save(figure, output.path(f"plots/{name}{suffix}.png"))


def _chosen_axes(field: Field) -> tuple[str, str | None]:
    """The axis along which curves run, and the height of a map if there is to be one."""
    names = list(field.axes)
    along = names[-1]
    others = [name for name in names if name != along]
    longest = max(others, key=lambda name: len(field.axes[name]), default=None)
    if longest is None or len(field.axes[longest]) <= MOST_CURVES or len(field.axes[along]) < 2:
        return along, None
    return along, longest


def amplitude_curves(field: Field, title: str = "") -> Figure:
    """Amplitude over base amplitude along the last axis, coloured by stops a cycle, the stop regions marked;
    one panel for each value of the other axis, if there is one (six at most)."""
    along = list(field.axes)[-1]
    panels = list(curves(field, along))[:MOST_CURVES]
    colours = stop_colours(field.outcomes["stops"])
    with style():
        figure = new_figure(9.0, 1.0 + (3.2 if len(panels) == 1 else 2.3 * len(panels)))
        grid = figure.subplots(len(panels), 1, squeeze=False, sharex=True, sharey=True)[:, 0]
        for axes, (chosen, curve) in zip(grid, panels, strict=True):
            curve_with_regions(
                axes, curve.axes[along], curve.outcomes["amplitude_ratio"], curve.outcomes["stops"], colours
            )
            axes.set_title(", ".join(words for words in (title, said(field, chosen)) if words), pad=16)
        scale_axis(grid[-1], "x", field.axes[along], AXES[along].factor)
        scale_axis(grid[-1], "y", _positive(field.outcomes["amplitude_ratio"]), 1.0)
        grid[-1].set_xlabel(axis_label(along))
        figure.supylabel(AMPLITUDE_LABEL, fontsize=9.0)
        if not np.all(np.isfinite(field.outcomes["stops"])):
            grid[0].legend(loc="upper left", handlelength=1.0)
    return figure


def amplitude_map(field: Field, title: str = "") -> Figure:
    """Two maps over the two axes of the field, the last of them across: amplitude over base amplitude with
    the borders between stop regions, and stops a cycle, rounded where they differ from cycle to cycle."""
    up, along = field.axes
    x, y = (AXES[name].factor * field.axes[name] for name in (along, up))
    amplitude, stops = field.outcomes["amplitude_ratio"], np.round(field.outcomes["stops"])
    with style():
        figure = new_figure(10.0, 4.6)
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        for axes in (left, right):
            axes.grid(False)
            axes.set_facecolor("#ffffff")
        finite = _positive(amplitude)
        wide = len(finite) > 0 and finite.max() > WIDE_RANGE * finite.min()
        norm = LogNorm() if wide else Normalize()
        mesh = left.pcolormesh(
            _edges(x), _edges(y), amplitude, norm=norm, cmap="viridis", rasterized=True, shading="flat"
        )
        bar = figure.colorbar(mesh, ax=left, label=AMPLITUDE_LABEL, pad=0.02)
        if wide:
            _log_ticks(bar.ax.yaxis, finite.min(), finite.max())
        _borders(left, x, y, stops)
        _stops_mesh(figure, right, x, y, stops)
        for axes in (left, right):
            scale_axis(axes, "x", field.axes[along], AXES[along].factor)
            scale_axis(axes, "y", field.axes[up], AXES[up].factor)
            axes.set_xlabel(axis_label(along))
        left.set_ylabel(axis_label(up))
        left.set_title("amplitude; lines: where the number of stops changes")
        right.set_title("stops a cycle" + ("" if np.all(np.isfinite(stops)) else "; white: not periodic"))
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    return figure


def stop_colours(stops: NDArray[np.float64]) -> Mapping[float, Any]:
    """A colour for each number of stops that occurs, from dark for none to bright for twelve (or for the most
    stops, where there are more)."""
    present = np.unique(stops[np.isfinite(stops)])
    most = max(MANY_STOPS, float(present.max(initial=0.0)))
    return {float(number): colormaps["plasma"](BRIGHTEST * number / most) for number in present}


def curve_with_regions(
    axes: Axes,
    x: NDArray[np.float64],
    amplitude: NDArray[np.float64],
    stops: NDArray[np.float64],
    colours: Mapping[float, Any],
) -> None:
    """One amplitude curve over ascending `x` in the colours of its stops; its stop regions are shaded in turn
    and named above the frame. States that are not periodic are crosses."""
    found = regions(x, bridged(stops))
    for number, region in enumerate(found):
        if number % 2:
            axes.axvspan(region.low, region.high, color=SHADE, lw=0, zorder=0)
        if region.stops is not None:
            _segment(axes, x, amplitude, region, colours[region.stops])
    lost = ~np.isfinite(stops)
    axes.plot(x[lost], amplitude[lost], "x", color=NOT_PERIODIC, ms=3.0, mew=0.7, label="not periodic")
    if len(x) > 1:
        axes.set_xlim(x[0], x[-1])
        scale_axis(axes, "x", x, 1.0)
    axes.margins(y=0.06)
    _name_regions(axes, found, colours)


def _segment(axes: Axes, x: NDArray[Any], y: NDArray[Any], region: Region, colour: Any) -> None:
    """The curve within one region, out to the middle of the steps at its ends."""
    first, last = max(region.first - 1, 0), min(region.last + 1, len(x) - 1)
    inside = slice(first, last + 1)
    points = np.column_stack([x[inside], y[inside]])
    if first < region.first:
        points[0] = (points[0] + points[1]) / 2
    if last > region.last:
        points[-1] = (points[-1] + points[-2]) / 2
    if len(points) < 3:
        axes.plot(x[region.first], y[region.first], ".", color=colour, ms=4.0)
    axes.add_collection(LineCollection([points], colors=[colour], linewidths=1.6))


def _name_regions(axes: Axes, found: Sequence[Region], colours: Mapping[float, Any]) -> None:
    place = axes.get_xaxis_transform()
    whole = _stretch(axes, *axes.get_xlim())
    for region in found:
        if region.stops is None or _stretch(axes, region.low, region.high) < LEAST_LABELLED * whole:
            continue
        log = axes.get_xscale() == "log"
        middle = math.sqrt(region.low * region.high) if log else (region.low + region.high) / 2
        axes.text(
            middle,
            1.015,
            f"{region.stops:.3g}",
            transform=place,
            ha="center",
            va="bottom",
            fontsize=8.5,
            fontweight="bold",
            color=colours[region.stops],
        )
    axes.text(1.01, 1.015, "stops", transform=axes.transAxes, ha="left", va="bottom", fontsize=8.0)


def _stretch(axes: Axes, low: float, high: float) -> float:
    return math.log(high / low) if axes.get_xscale() == "log" else high - low


def scale_axis(axes: Axes, which: str, values: NDArray[np.float64], factor: float) -> None:
    """Makes an axis logarithmic, with ticks at 1, 2 and 5, where the values span a wide range."""
    low, high = float(np.min(values, initial=np.inf)), float(np.max(values, initial=0.0))
    if low <= 0 or high < WIDE_RANGE * low:
        return
    getattr(axes, f"set_{which}scale")("log")
    _log_ticks(axes.xaxis if which == "x" else axes.yaxis, factor * low, factor * high)


def _log_ticks(axis: Any, low: float, high: float) -> None:
    decades = math.log10(high / low)
    subs = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0) if decades < 1.5 else (1.0, 2.0, 5.0) if decades < 3 else (1.0,)
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def _positive(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values[np.isfinite(values) & (values > 0)]


def axis_label(name: str) -> str:
    """What stands at an axis of a sweep."""
    if name == "ratios":
        return RATIO_LABEL
    axis = AXES[name]
    return f"{axis.meaning} [{axis.unit}]" if axis.unit else axis.meaning


def _edges(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """The borders between cells around ascending centres."""
    inner = (centres[1:] + centres[:-1]) / 2
    return np.r_[centres[0] - (inner[0] - centres[0]), inner, centres[-1] + (centres[-1] - inner[-1])]


def _borders(axes: Axes, x: NDArray[Any], y: NDArray[Any], stops: NDArray[Any]) -> None:
    """Lines between cells with different numbers of stops, where both have one."""
    across, up = _edges(x), _edges(y)
    row, column = np.nonzero(np.abs(np.diff(stops, axis=1)) > 0)
    vertical = [
        [(across[j + 1], up[i]), (across[j + 1], up[i + 1])] for i, j in zip(row, column, strict=True)
    ]
    row, column = np.nonzero(np.abs(np.diff(stops, axis=0)) > 0)
    level = [[(across[j], up[i + 1]), (across[j + 1], up[i + 1])] for i, j in zip(row, column, strict=True)]
    axes.add_collection(LineCollection(vertical + level, colors="white", linewidths=0.5))


def _stops_mesh(figure: Figure, axes: Axes, x: NDArray[Any], y: NDArray[Any], stops: NDArray[Any]) -> None:
    colours = stop_colours(stops)
    numbers = list(colours)
    if not numbers:
        return
    palette: Colormap = ListedColormap([colours[number] for number in numbers])
    rank = np.searchsorted(numbers, np.where(np.isfinite(stops), stops, numbers[0])).astype(float)
    rank[~np.isfinite(stops)] = np.nan
    norm = BoundaryNorm(np.arange(len(numbers) + 1) - 0.5, len(numbers))
    mesh = axes.pcolormesh(
        _edges(x), _edges(y), rank, norm=norm, cmap=palette, rasterized=True, shading="flat"
    )
    bar = figure.colorbar(mesh, ax=axes, label="stops a cycle", pad=0.02)
    bar.ax.yaxis.set_major_locator(FixedLocator(range(len(numbers))))
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda rank, _: f"{numbers[round(rank)]:.3g}"))
    bar.ax.yaxis.set_minor_locator(NullLocator())
