"""The friction force over the sliding velocity, with the identified and the assumed law."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from fitting.result import Fit, Trace
from jaxstick.plots.style import ASSUMED, FITTED, MEASURED, length_unit, new_figure, style, thinned

MOST_POINTS = 6000
DECADES = 3.0


def friction_law(fit: Fit) -> Figure:
    """All runs' friction force over the sliding velocity; on the right only what opposes the motion, over the
    logarithm of the speed, as Stribeck curves are drawn.

    Points are measured (fitted where no friction force was), velocities read off the displacement. Near
    standstill the contact holds: there the points leave the law.
    """
    speed, force = _points(fit.traces)
    constants = {constant.name: constant for constant in fit.constants}
    identified = {name: constant.value for name, constant in constants.items()}
    assumed = {name: constant.assumed for name, constant in constants.items()}
    top = float(np.max(np.abs(speed)))
    factor, unit = length_unit(top)
    recorded = any(trace.run.friction is not None for trace in fit.traces)
    label = "measured" if recorded else "fitted (no force measured)"
    with style():
        figure = new_figure(10.0, 4.4)
        left, right = figure.subplots(1, 2)
        few = thinned(len(speed), MOST_POINTS)
        left.plot(factor * speed[few], force[few], ".", color=MEASURED, ms=2.0, mew=0, alpha=0.5, label=label)
        against = np.abs(speed) > top * 10**-DECADES
        right.plot(
            factor * np.abs(speed[against])[few],
            (-np.sign(speed) * force)[against][few],
            ".",
            color=MEASURED,
            ms=2.0,
            mew=0,
            alpha=0.5,
        )
        _law(left, right, assumed, top, factor, ASSUMED, "assumed law", (0, (4, 2)))
        _law(left, right, identified, top, factor, FITTED, "identified law", "-")
        left.set_xlabel(f"sliding velocity [{unit}/s]")
        left.set_ylabel("friction force F [N]")
        left.legend(loc="upper right", markerscale=4)
        right.set_xscale("log")
        right.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        right.set_xlim(left=factor * top * 10**-DECADES)
        highest = max(identified["A"] + identified["C"], (assumed["A"] or 0.0) + (assumed["C"] or 0.0))
        right.set_ylim(0.0, 1.25 * max(highest, float(np.quantile(np.abs(force), 0.99))))
        right.set_xlabel(f"speed |v| [{unit}/s]")
        right.set_ylabel("friction force against the motion [N]")
    return figure


def _points(traces: tuple[Trace, ...]) -> tuple[np.ndarray, np.ndarray]:
    speed = np.concatenate([trace.slide_rate for trace in traces])
    force = [trace.friction if trace.run.friction is None else trace.run.friction for trace in traces]
    return speed, np.concatenate(force)


def _law(
    left: Axes,
    right: Axes,
    constants: Mapping[str, float | None],
    top: float,
    factor: float,
    colour: str,
    label: str,
    dashes: object,
) -> None:
    """A exp(-B |v|) + C + D |v|, where C is known; A, B and D count as 0 where nothing is said."""
    if constants["C"] is None:
        return
    a, b, c, d = (constants[name] or 0.0 for name in ("A", "B", "C", "D"))
    speed = top * np.concatenate([[0.0], np.logspace(-DECADES, 0, 300)])
    law = a * np.exp(-b * speed) + c + d * speed
    both = np.concatenate([-speed[::-1], speed]), np.concatenate([law[::-1], -law])
    left.plot(factor * both[0], both[1], color=colour, lw=1.6, ls=dashes, label=label)
    right.plot(factor * speed[1:], law[1:], color=colour, lw=1.6, ls=dashes)
