"""How probable each explanation is, as bars."""

from __future__ import annotations

from matplotlib.figure import Figure

from fitting.diagnosis.findings import Diagnosis
from jaxstick.plots.style import FITTED, HALO, new_figure, style

MOST = 8


def probabilities(diagnosis: Diagnosis) -> Figure:
    """The likeliest explanations, most probable on top; the named ones in colour."""
    ranked = sorted(diagnosis.probabilities.items(), key=lambda item: -item[1])[:MOST]
    named = set(diagnosis.named) or {diagnosis.verdict}
    with style():
        figure = new_figure(8.0, 0.38 * len(ranked) + 0.9)
        axes = figure.subplots()
        colours = [FITTED if key in named else HALO for key, _ in ranked]
        bars = axes.barh([key for key, _ in ranked], [share for _, share in ranked], color=colours)
        axes.bar_label(bars, [f"{share:.1%}".replace("%", " %") for _, share in ranked], padding=4)
        axes.invert_yaxis()
        axes.set_xlim(0.0, 1.12)
        axes.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0])
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("probability")
    return figure
