"""What a fit leaves of a run: over time, its distribution, and whether it is white."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fitting.result import Gap, Trace
from jaxstick.plots.style import ASSUMED, BAND, FITTED, MEASURED, length_unit, new_figure, style

MOST_COLUMNS = 1500
LAGS = 60


def residuals(trace: Trace, gaps: Sequence[Gap]) -> Figure:
    """Measured less fitted, a row each for displacement and friction force.

    Left over time, with a band of two standard deviations of the noise; in the middle their distribution
    beside the noise's; right their autocorrelation with the band in which 95 % of white noise stays.
    """
    run = trace.run
    floors = {gap.channel: gap.floor for gap in gaps if gap.file == run.file}
    rows = [("displacement x", "m", run.displacement - trace.displacement, floors["displacement"])]
    if run.friction is not None and "friction" in floors:
        rows.append(("friction F", "N", run.friction - trace.friction, floors["friction"]))
    with style():
        figure = new_figure(11.0, 2.6 * len(rows) + 0.4)
        panels = figure.subplots(len(rows), 3, squeeze=False, width_ratios=(2.6, 1.0, 1.2))
        for axes, (name, unit, left, floor) in zip(panels, rows, strict=True):
            factor, shown = length_unit(3 * floor) if unit == "m" else _force_unit(3 * floor)
            _over_time(axes[0], run.time, factor * left, factor * floor)
            axes[0].set_ylabel(f"{name},\nmeasured - fitted [{shown}]")
            _distribution(axes[1], left / floor)
            _autocorrelation(axes[2], left)
        panels[0][0].set_title(run.file + (", held out" if run.hold_out else ""))
        panels[-1][0].set_xlabel("time [s]")
        panels[-1][1].set_xlabel("residual / noise")
        panels[-1][2].set_xlabel("lag [samples]")
    return figure


def _force_unit(size: float) -> tuple[float, str]:
    return (1.0, "N") if size >= 0.5 else (1e3, "mN")


def _over_time(axes: Axes, time: np.ndarray, left: np.ndarray, floor: float) -> None:
    """Up to 1500 samples as they are; more as the range within each of 1500 stretches, so that no extreme is
    lost."""
    axes.axhspan(-2 * floor, 2 * floor, color=BAND, alpha=0.3, lw=0, label="2 sd of the noise")
    if len(time) <= MOST_COLUMNS:
        axes.plot(time, left, color=FITTED, lw=0.6)
    else:
        edges = np.linspace(0, len(time), MOST_COLUMNS + 1).astype(int)[:-1]
        low, high = np.minimum.reduceat(left, edges), np.maximum.reduceat(left, edges)
        axes.fill_between(time[edges], low, high, color=FITTED, lw=0.3, step="post")
    axes.legend(loc="upper right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1)
    axes.margins(x=0.01)
    reach = max(4.5 * floor, 1.1 * float(np.max(np.abs(left))))
    axes.set_ylim(-reach, reach)


def _distribution(axes: Axes, scaled: np.ndarray) -> None:
    reach = float(np.clip(1.1 * np.max(np.abs(scaled)), 4.0, 12.0))
    bins = np.linspace(-reach, reach, 61)
    axes.hist(np.clip(scaled, -reach, reach), bins.tolist(), density=True, color=FITTED, alpha=0.75)
    normal = np.exp(-(bins**2) / 2) / np.sqrt(2 * np.pi)
    axes.plot(bins, normal, color=MEASURED, lw=1.2, label="noise")
    axes.set_yticks([])
    axes.set_ylabel("density")
    axes.legend(loc="upper right", handlelength=1.0, borderaxespad=0.1)


def _autocorrelation(axes: Axes, left: np.ndarray) -> None:
    count = len(left)
    lags = np.arange(1, min(LAGS, count - 1) + 1)
    centred = left - left.mean()
    padded = np.fft.rfft(centred, 2 * count)
    correlation = np.fft.irfft(np.abs(padded) ** 2)[: lags[-1] + 1]
    correlation = correlation / correlation[0] if correlation[0] > 0 else correlation
    bound = 1.96 / np.sqrt(count)
    axes.axhspan(-bound, bound, color=BAND, alpha=0.3, lw=0)
    axes.vlines(lags, 0.0, correlation[1:], color=FITTED, lw=1.0)
    axes.axhline(0.0, color=MEASURED, lw=0.7)
    axes.plot(lags, correlation[1:], ".", color=ASSUMED, ms=3)
    reach = max(0.2, 1.15 * float(np.max(np.abs(correlation[1:]))))
    axes.set_ylim(-reach, reach)
    axes.set_ylabel("autocorrelation")
