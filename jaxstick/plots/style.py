"""The look that all figures share: colours that colour-blind readers can tell apart, sizes, units, saving."""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

# Okabe and Ito's palette (jfly.uni-koeln.de/color).
MEASURED = "#4d4d4d"
HALO = "#a6a6a6"
FITTED = "#0072B2"
ASSUMED = "#D55E00"
FREE_RUN = "#009E73"
BASE = "#999999"
BAND = "#56B4E9"
SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

MOST_POINTS = 4000
"""Markers of one channel beyond which a plot is thinned."""

_DOTS_PER_INCH = 130
_SETTINGS: dict[str, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": f"cycler('color', {list(SERIES)!r})",
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
}


def style() -> Any:
    """A context in which figures are made in the house style; matplotlib's own settings are left alone."""
    return rc_context(_SETTINGS)  # pyright: ignore[reportArgumentType]


def new_figure(width: float, height: float) -> Figure:
    """An empty figure [inches], laid out by itself; belongs inside `style()`."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


class Margins(NamedTuple):
    """Room around the axes of a figure, and between them side by side and one above the other [inches]."""

    left: float
    right: float
    bottom: float
    top: float
    across: float = 0.0
    down: float = 0.0


def framed(figure: Figure, margins: Margins, columns: int = 1, rows: int = 1) -> None:
    """Places the axes of a figure by margins, not by the size of their labels: finding that takes longer than
    drawing does. For axes whose labels are known to be short."""
    figure.set_layout_engine(None)
    width, height = figure.get_size_inches()
    inner = width - margins.left - margins.right, height - margins.bottom - margins.top
    figure.subplots_adjust(
        left=margins.left / width,
        right=1 - margins.right / width,
        bottom=margins.bottom / height,
        top=1 - margins.top / height,
        wspace=columns * margins.across / (inner[0] - (columns - 1) * margins.across),
        hspace=rows * margins.down / (inner[1] - (rows - 1) * margins.down),
    )


def save(figure: Figure, path: Path) -> None:
    """Writes a PNG that says nothing of when and by what it was made."""
    figure.savefig(path, dpi=_DOTS_PER_INCH, metadata={"Software": None})


def thinned(samples: int, most: int = MOST_POINTS) -> slice:
    """Every how manieth of so many samples to draw."""
    return slice(None, None, max(1, math.ceil(samples / most)))


def length_unit(size: float) -> tuple[float, str]:
    """A unit in which lengths of this size [m] are read easily: how many of it are a metre, and its name."""
    for factor, name in ((1.0, "m"), (1e3, "mm"), (1e6, "um")):
        if size * factor >= 0.5:
            return factor, "µm" if name == "um" else name
    return 1e9, "nm"


def span(values: NDArray[np.float64]) -> float:
    """The largest magnitude among the values that are finite; 0 where none is."""
    finite = values[np.isfinite(values)]
    return float(np.max(np.abs(finite))) if len(finite) else 0.0


def legend_above(axes: Axes, columns: int = 5) -> None:
    """The legend in one row above the axes, at the right end."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.2, handlelength=1.6
    )
