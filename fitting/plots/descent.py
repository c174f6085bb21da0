"""How the search went: the descents from several starts, and the least squares after them."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from fitting.result import Fit
from jaxstick.plots.style import FITTED, MEASURED, SERIES, new_figure, style


def descent(fit: Fit) -> Figure:
    """Left the loss of every descent over its iterations, best so far; right how far the least-squares cost
    still lay above its end, step by step."""
    best = np.minimum.accumulate(np.nan_to_num(fit.descent, nan=np.inf), axis=0)
    iterations = np.arange(1, len(best) + 1)
    order = np.argsort(best[-1])
    with style():
        figure = new_figure(10.0, 3.8)
        left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
        for rank, start in enumerate(order):
            first = rank == 0
            left.plot(
                iterations,
                best[:, start],
                color=FITTED if first else SERIES[1 + (rank - 1) % (len(SERIES) - 1)],
                lw=2.0 if first else 1.0,
                zorder=3 if first else 2,
                label=f"start {start + 1}",
            )
        left.set_xlabel("iteration of the descent")
        left.set_ylabel("loss, best so far")
        if len(order) <= 12:
            left.legend(title="best first", ncols=2)
        cost = np.asarray(fit.finish, float)
        above = cost - cost[-1]
        right.plot(np.arange(len(cost))[above > 0], above[above > 0], "o-", color=MEASURED, ms=3.5)
        right.set_yscale("log")
        right.set_xlabel("step of the least squares")
        right.set_ylabel("chi² above its end")
    return figure
