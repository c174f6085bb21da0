"""The pictures of a score, as SVG for its page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from fitting.blind.menu import FAMILIES
from fitting.report.inline_svg import draw
from jaxstick.plots.style import ASSUMED, BAND, FITTED, MEASURED, SERIES


class Picture(NamedTuple):
    """A drawing and what stands above it."""

    title: str
    drawing: Markup


def pictures(score: Mapping[str, Any]) -> Iterator[Picture]:
    """Reliability, detection-limit curves, and the confusion matrix, as far as there are cases for them."""
    whole = score["tiers"]["all"]
    if whole["calibration"]["bins"]:
        drawing = draw(
            lambda axes: _reliability(axes, whole["calibration"]),
            "reliability",
            "Share of right answers over the stated confidence, with 95 % intervals",
        )
        yield Picture("Reliability: what is stated and what is so", drawing)
    labels = {
        "predicted_ratio": ("predicted", "strength over the limit that the diagnosis predicts"),
        "limit_ratio": ("limit", "gap over the detection limit of an ideal observer"),
        "gap_ratio": ("gap", "gap over the noise"),
    }
    for key, (name, label) in labels.items():
        curves = {tier: one["limits"][key] for tier, one in score["tiers"].items() if one["limits"].get(key)}
        if curves:
            drawing = draw(
                lambda axes, curves=curves, label=label: _curves(axes, curves, label),
                f"named-over-{name}",
                f"Probability of naming the one effect against the {label}",
                legend=True,
            )
            yield Picture(f"Probability of naming, against the {label}", drawing)
    if score["confusion"]:
        rows = len(score["confusion"])
        drawing = draw(
            lambda axes: _confusion(axes, score["confusion"]),
            "confusion",
            "Answers for every truth, as shares of its cases",
            height=1.4 + 0.1 * rows + 0.05 * len(_answers(score["confusion"])),
        )
        yield Picture("Answers (columns) for every truth (rows)", drawing)


def _reliability(axes: Axes, found: Mapping[str, Any]) -> None:
    axes.plot([0, 1], [0, 1], color=MEASURED, linewidth=0.8, linestyle="--")
    mean = [one["confidence"] for one in found["bins"]]
    right = np.array([one["right"]["value"] for one in found["bins"]])
    ends = np.array([[one["right"]["low"], one["right"]["high"]] for one in found["bins"]])
    spread = np.abs(ends.T - right)
    axes.errorbar(mean, right, yerr=spread, fmt="o", color=FITTED, markersize=3.5, elinewidth=0.9)
    axes.set(xlabel="stated probability", ylabel="share right", xlim=(-0.02, 1.02), ylim=(-0.02, 1.02))


def _curves(axes: Axes, curves: Mapping[str, Mapping[str, Any]], label: str) -> None:
    whole = curves.get("all")
    if whole is not None:
        axes.fill_between(whole["ratio"], whole["low"], whole["high"], color=BAND, alpha=0.25, linewidth=0)
        groups = whole["groups"]
        axes.plot(
            [one["ratio"] for one in groups],
            [one["named"]["value"] for one in groups],
            "o",
            color=MEASURED,
            markersize=3,
        )
    for (tier, one), colour in zip(curves.items(), SERIES, strict=False):
        width = 1.6 if tier == "all" else 1.0
        axes.plot(one["ratio"], one["probability"], color=colour, linewidth=width, label=tier)
    axes.axhline(0.9, color=ASSUMED, linewidth=0.7, linestyle=":")
    axes.set(xscale="log", xlabel=label, ylabel="named", ylim=(-0.02, 1.02))


def _answers(confusion: Mapping[str, Mapping[str, int]]) -> list[str]:
    """Every answer that was given, in the order of the truths and then of the catalogue."""
    order = ["none", *FAMILIES, "unlisted", "several", "no answer"]
    given = {answer for row in confusion.values() for answer in row}
    known = [answer for answer in order if answer in given]
    return known + sorted(given - set(known))


def _confusion(axes: Axes, confusion: Mapping[str, Mapping[str, int]]) -> None:
    """Squares whose depth is the share; drawn as patches, so that they take the page's colours."""
    answers = _answers(confusion)
    for place, (_, row) in enumerate(confusion.items()):
        total = sum(row.values())
        for answer, count in row.items():
            left = answers.index(answer)
            axes.fill_between(
                [left - 0.46, left + 0.46],
                place - 0.46,
                place + 0.46,
                color=FITTED,
                alpha=0.15 + 0.85 * count / total,
                linewidth=0,
            )
    axes.set_xticks(range(len(answers)), answers, rotation=90, fontsize=4.5)
    axes.set_yticks(range(len(confusion)), list(confusion), fontsize=4.5)
    axes.set(xlim=(-0.6, len(answers) - 0.4), ylim=(len(confusion) - 0.4, -0.6))
    axes.grid(visible=True, linewidth=0.3)
