"""A simulated run over time and as a friction loop, beside its record where there is one."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxstick.plots.style import ASSUMED, BASE, MEASURED, legend_above, length_unit, new_figure, span, style
from jaxstick.record import Run

CYCLES = 2.0


def motion(simulated: Run, measured: Run | None = None, frequency: float | None = None) -> Figure:
    """Displacement and friction force over the last two cycles, and the force over the displacement.

    Without a drive `frequency` [Hz] the whole run is shown.
    """
    time = simulated.time
    last = time[-1] - (CYCLES / frequency if frequency else np.inf)
    shown = time >= last
    factor, unit = length_unit(span(simulated.displacement))
    with style():
        figure = new_figure(10.0, 5.0)
        grid = figure.add_gridspec(2, 2, width_ratios=(2.2, 1.0))
        above = figure.add_subplot(grid[0, 0])
        below = figure.add_subplot(grid[1, 0], sharex=above)
        loop = figure.add_subplot(grid[:, 1])
        if simulated.base is not None:
            above.plot(time[shown], factor * simulated.base[shown], color=BASE, lw=1.0, ls="--", label="base")
        for run, colour, label in ((measured, MEASURED, "recorded"), (simulated, ASSUMED, "simulated")):
            if run is not None:
                _channel(above, time[shown], factor * run.displacement[shown], colour, label)
                if run.friction is not None:
                    _channel(below, time[shown], run.friction[shown], colour, label)
                    loop.plot(
                        factor * run.displacement[shown],
                        run.friction[shown],
                        color=colour,
                        lw=1.0,
                        label=label,
                    )
        above.set_ylabel(f"displacement x [{unit}]")
        above.set_title(f"{simulated.file}, constants as assumed")
        above.tick_params(labelbottom=False)
        legend_above(above)
        below.set_ylabel("friction force F [N]")
        below.set_xlabel("time [s]")
        below.margins(x=0.01)
        loop.set_xlabel(f"displacement x [{unit}]")
        loop.set_ylabel("friction force F [N]")
    return figure


def _channel(axes: Axes, time: np.ndarray, values: np.ndarray, colour: str, label: str) -> None:
    axes.plot(time, values, color=colour, lw=1.2, label=label)
