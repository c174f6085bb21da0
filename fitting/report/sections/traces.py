"""Traces before and after."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from fitting.diagnosis.findings import Trace
from fitting.plots import before_after as panels
from fitting.plots.diagnosis_gallery import frequencies, worst_first
from fitting.report.inline_svg import draw
from fitting.report.section import Picture, Section, Subject
from fitting.report.words import NONE, percent

MOST_RUNS = 8
"""Runs that the page shows; the others are in the folder of plots."""


def traces(subject: Subject) -> Section:
    """The worst run first, the others folded."""
    diagnosis, frequency = subject.diagnosis, frequencies(subject.dataset)
    ordered = worst_first(diagnosis)
    shares = {} if diagnosis.verdict == NONE else diagnosis.where.run
    runs = [
        _run(trace, frequency.get(trace.file), shares, f"run-{place}")
        for place, trace in enumerate(ordered[:MOST_RUNS], start=1)
    ]
    left_out = [trace.file for trace in ordered[MOST_RUNS:]]
    content = {"runs": runs, "left_out": left_out}
    return Section("traces", "Traces before and after", "traces.html", content)


def _run(trace: Trace, frequency: float | None, shares: Mapping[str, float], name: str) -> dict[str, Any]:
    shown = panels.worst_window(trace, frequency)
    stretch = "two cycles" if frequency is not None else f"{shown.stop - shown.start} samples"
    drawings = [
        (
            "displacement",
            f"Displacement, the {stretch} that the nominal model misses most",
            partial(panels.displacement, trace=trace, shown=shown),
        ),
        (
            "friction",
            "Friction force, the same stretch"
            + ("" if trace.friction is not None else " (not recorded: models only)"),
            partial(panels.friction, trace=trace, shown=shown),
        ),
        (
            "displacement-left",
            "What is left of the displacement, whole run",
            partial(panels.displacement_left, trace=trace),
        ),
    ]
    if trace.friction is not None:
        drawings.append(
            (
                "friction-left",
                "What is left of the friction force, whole run",
                partial(panels.friction_left, trace=trace),
            )
        )
    drawn = partial(draw, legend=True, margins=panels.MARGINS)
    facts = [] if frequency is None else [f"{frequency:.3g} Hz"]
    if trace.held_out:
        facts.append("held out")
    elif trace.file in shares:
        facts.append(f"{percent(shares[trace.file])} of the excess")
    return {
        "file": trace.file,
        "facts": ", ".join(facts),
        "pictures": [
            Picture(words, drawn(panel, f"{name}-{kind}", f"{trace.file}: {words}."))
            for kind, words, panel in drawings
        ],
    }
