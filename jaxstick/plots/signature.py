"""The signature of an effect: a cycle with and without it, the differences, and the loops of friction."""

import numpy as np
from jax.typing import ArrayLike
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxstick.plots.style import ASSUMED, FITTED, MEASURED, legend_above, length_unit, new_figure, span, style
from jaxstick.signature import Signature


def draw_signature(seen: Signature) -> Figure:
    """Displacement and friction force as read over one cycle, what the effect changes in each, and the force
    over velocity and displacement."""
    without, changed = seen.without, seen.with_effect
    phase = np.linspace(0.0, 1.0, len(np.asarray(without.time)))
    factor, unit = length_unit(span(np.asarray(without.displacement)))
    with style():
        figure = new_figure(10.0, 6.0)
        grid = figure.add_gridspec(4, 2, width_ratios=(1.6, 1.0), height_ratios=(2.0, 1.0, 2.0, 1.0))
        first = figure.add_subplot(grid[0, 0])
        rows = [first] + [figure.add_subplot(grid[row, 0], sharex=first) for row in (1, 2, 3)]
        over_rate, over_place = figure.add_subplot(grid[:2, 1]), figure.add_subplot(grid[2:, 1])
        _pair(rows[0], phase, factor * without.displacement, factor * changed.displacement)
        _gap(rows[1], phase, changed.displacement - without.displacement, "x", "m")
        _pair(rows[2], phase, without.friction, changed.friction)
        _gap(rows[3], phase, changed.friction - without.friction, "F", "N")
        rows[0].set_ylabel(f"x [{unit}]")
        rows[2].set_ylabel("F [N]")
        rows[3].set_xlabel("cycle of the drive")
        for row in rows[:3]:
            row.tick_params(labelbottom=False)
        first.margins(x=0.01)
        legend_above(first)
        _pair(over_rate, without.v, without.friction, changed.v, changed.friction)
        _pair(
            over_place,
            factor * without.displacement,
            without.friction,
            factor * changed.displacement,
            changed.friction,
        )
        over_rate.set_xlabel("velocity v [m/s]")
        over_place.set_xlabel(f"displacement x [{unit}]")
        for axes in (over_rate, over_place):
            axes.set_ylabel("F [N]")
        given = ", ".join(_value(name, *value) for name, value in seen.values.items())
        figure.suptitle(f"{seen.title}: {given}", x=0.01, ha="left", fontsize=11)
    return figure


def _pair(axes: Axes, *curves: ArrayLike) -> None:
    """Two curves over one abscissa (x, y, y) or over their own (x, y, x, y)."""
    x, y, *rest = (np.asarray(curve) for curve in curves)
    over = rest[0] if len(rest) == 2 else x
    axes.plot(x, y, color=MEASURED, lw=1.2, label="without the effect")
    axes.plot(over, rest[-1], color=ASSUMED, lw=1.0, label="with it")


def _gap(axes: Axes, phase: np.ndarray, change: ArrayLike, name: str, unit: str) -> None:
    values = np.asarray(change)
    factor = 1.0
    if unit == "m":
        factor, unit = length_unit(span(values))
    axes.fill_between(phase, factor * values, color=FITTED, alpha=0.25, lw=0)
    axes.plot(phase, factor * values, color=FITTED, lw=0.9)
    axes.set_ylabel(f"Δ{name} [{unit}]")


def _value(name: str, value: float, unit: str) -> str:
    return f"{name.replace('_', ' ')} {value:.3g}" + ("" if unit == "1" else f" {unit}")
