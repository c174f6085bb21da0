"""The counterparts of the paper's figures 4 to 10."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from jaxstick.plots.style import BASE, FITTED, SERIES, legend_above, new_figure, style
from jaxstick.plots.sweep import AMPLITUDE_LABEL, RATIO_LABEL, curve_with_regions, scale_axis, stop_colours
from scripts.paper1987.claims import border
from scripts.paper1987.states import Curve, Response

CUT = 2.5
"""Amplitude over base amplitude at which the curves leave the frame: there are no stops above."""


def figure_4(response: Response) -> Figure:
    """Displacement of the mass and of the base over two cycles."""
    with style():
        figure = new_figure(8.5, 3.0)
        axes = figure.subplots()
        axes.plot(response.time, 1e3 * response.base, color=BASE, ls="--", lw=1.0, label="base y")
        axes.plot(response.time, 1e3 * response.displacement, color=FITTED, label="mass x")
        _over_time(axes, response)
        axes.set_ylabel("displacement [mm]")
        legend_above(axes)
    return figure


def figure_5(response: Response) -> Figure:
    """Velocity of the mass and friction force over two cycles."""
    with style():
        figure = new_figure(8.5, 4.4)
        above, below = figure.subplots(2, 1, sharex=True)
        above.plot(response.time, 1e3 * response.velocity, color=FITTED, lw=1.0)
        above.set_ylabel("velocity [mm/s]")
        below.plot(response.time, response.friction, color=SERIES[1], lw=1.0)
        below.set_ylabel("friction force [N]")
        above.set_title(f"$f/f_n$ = {response.ratio:g}, {response.stops:g} stops a cycle")
        _over_time(below, response)
        below.set_title("")
    return figure


def figure_6(response: Response) -> Figure:
    """Spectrum of the displacement, in dB below its first line."""
    level = 20 * np.log10(np.maximum(response.harmonics / response.harmonics[0], 1e-6))
    number = np.arange(1, len(level) + 1)
    with style():
        figure = new_figure(8.5, 3.0)
        axes = figure.subplots()
        floor = -90.0
        shown = np.maximum(level, floor)
        axes.vlines(number, floor, shown, color=FITTED, lw=2.4)
        for n in (3, 5):
            axes.annotate(
                f"{100 * response.harmonics[n - 1] / response.harmonics[0]:.1f} %",
                (n, shown[n - 1]),
                xytext=(0, 3),
                textcoords="offset points",
                ha="center",
                fontsize=8.5,
            )
        axes.set_ylim(floor, 8.0)
        axes.xaxis.set_major_locator(MultipleLocator(1))
        axes.grid(False, axis="x")
        axes.set_xlabel(f"harmonic of the drive ({response.frequency:.3f} Hz)")
        axes.set_ylabel("amplitude [dB]")
    return figure


def time_responses(responses: Sequence[Response]) -> Figure:
    """Displacement over one cycle of the drive at several frequency ratios."""
    with style():
        figure = new_figure(8.5, 1.75 * len(responses) + 0.4)
        for axes, response in zip(
            figure.subplots(len(responses), 1, sharex=True, squeeze=False)[:, 0], responses, strict=True
        ):
            half = len(response.time) // 2 + 1
            phase = response.time[:half] * response.frequency
            axes.plot(phase, 1e3 * response.base[:half], color=BASE, ls="--", lw=0.9, label="base y")
            axes.plot(phase, 1e3 * response.displacement[:half], color=FITTED, label="mass x")
            drive = f"$f/f_n$ = {response.ratio:g} ({response.frequency:.3f} Hz)"
            axes.set_title(f"{drive}: {response.stops:g} stops a cycle")
            axes.set_xlim(0.0, 1.0)
            axes.set_ylabel("[mm]")
        axes.set_xlabel("cycles of the drive")
        legend_above(figure.axes[0])
    return figure


def amplitude_curves(curves: Sequence[Curve]) -> Figure:
    """Amplitude over base amplitude, one panel a curve, with the stop regions marked."""
    colours = stop_colours(np.concatenate([curve.stops for curve in curves]))
    with style():
        figure = new_figure(9.0, 2.4 * len(curves) + 0.5)
        panels = figure.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0]
        for axes, curve in zip(panels, curves, strict=True):
            curve_with_regions(axes, curve.ratios, curve.amplitude, curve.stops, colours)
            axes.set_title(curve.label, pad=16)
            scale_axis(axes, "y", curve.amplitude[np.isfinite(curve.amplitude)], 1.0)
            axes.set_ylim(0.9 * np.nanmin(curve.amplitude), CUT)
        scale_axis(panels[-1], "x", curves[0].ratios, 1.0)
        panels[-1].set_xlabel(RATIO_LABEL)
        figure.supylabel(AMPLITUDE_LABEL, fontsize=9.0)
    return figure


def curves_together(curves: Sequence[Curve]) -> Figure:
    """Amplitude over base amplitude, all curves in one frame; dots where the number of stops changes."""
    with style():
        figure = new_figure(9.0, 4.0)
        axes = figure.subplots()
        for curve, colour in zip(curves, SERIES, strict=False):
            axes.plot(curve.ratios, curve.amplitude, color=colour, lw=1.1, label=curve.label)
            for stops in range(2, 11, 2):
                place = border(curve, stops)
                if np.isfinite(place):
                    height = np.interp(place, curve.ratios, curve.amplitude)
                    axes.plot(place, height, "o", color=colour, ms=4.0)
        for which, values in (("x", curves[0].ratios), ("y", np.concatenate([c.amplitude for c in curves]))):
            scale_axis(axes, which, values[np.isfinite(values)], 1.0)
        axes.set_ylim(0.9 * min(np.nanmin(curve.amplitude) for curve in curves), CUT)
        axes.margins(x=0.01)
        axes.set_xlabel(RATIO_LABEL)
        axes.set_ylabel(AMPLITUDE_LABEL)
        axes.legend(loc="upper left")
    return figure


def _over_time(axes, response: Response) -> None:
    axes.set_title(f"$f/f_n$ = {response.ratio:g}, {response.stops:g} stops a cycle")
    axes.set_xlabel("time [s]")
    axes.margins(x=0.01)
