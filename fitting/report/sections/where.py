"""Where simulation and record part: shares of the excess, and the force that the nominal model lacks."""

from __future__ import annotations

from functools import partial

from fitting.diagnosis.findings import Diagnosis, Patterns, Shares
from fitting.diagnosis.where.clue import BEAT, FRICTION, MECHANICS, MOTION
from fitting.plots import residual_force as panels
from fitting.plots.diagnosis_gallery import worst_residual_run
from fitting.report.inline_svg import draw
from fitting.report.section import Bar, Picture, Section, Subject
from fitting.report.words import NONE, clamped, harmonic, largest, number, percent

MOST_BARS = 12
LEAST = 0.05
"""A pattern that foretells less of the excess is not drawn."""
SIDES = {
    MECHANICS: "Motion, friction as it was measured",
    MOTION: "Motion",
    FRICTION: "Friction force, in slip",
}


def where(subject: Subject) -> Section:
    """Every split of the excess, and the residual force in four pictures."""
    diagnosis = subject.diagnosis
    found = diagnosis.where
    splits = (
        ("Side", found.side),
        ("Channel", found.channel),
        ("Phase of motion", found.phase),
        ("Direction", found.direction),
        ("Run", found.run),
        ("Harmonic of the drive", {harmonic(name): share for name, share in found.harmonic.items()}),
    )
    content = {
        "within_noise": diagnosis.verdict == NONE,
        "excess": number(found.excess),
        "significance": number(found.significance),
        "splits": [(title, _bars(shares)) for title, shares in splits if shares],
        "time": _columns(found.time),
        "pictures": _pictures(diagnosis),
        "follows": [(SIDES[side], *_follows(found)) for side, found in diagnosis.follows.items()],
        "sketch": [(term, f"{size:+.3g}") for term, size in diagnosis.residual_force.sketch.items()],
    }
    return Section("where", "Where they part", "where.html", content)


def _bars(shares: Shares) -> list[Bar]:
    top = largest(shares)
    shown = list(shares.items())
    if len(shown) > MOST_BARS:
        shown = sorted(shown, key=lambda item: -item[1])[:MOST_BARS]
    return [
        Bar(label, percent(share), clamped(share), strong=top is not None and label == top[0])
        for label, share in shown
    ]


def _follows(found: Patterns) -> tuple[str, list[Bar]]:
    """How large the excess of a side is, and a bar for every pattern that foretells a part of it."""
    line = f"Excess {number(found.excess)}, {number(found.significance)} standard deviations above zero"
    if found.apart:
        segments = "segment" if found.apart == 1 else "segments"
        line += f", without {found.apart} {segments} far worse than the rest"
    shares = {_pattern(name, found): share for name, share in found.shares.items()}
    return f"{line}.", _bars({name: share for name, share in shares.items() if share >= LEAST})


def _pattern(name: str, found: Patterns) -> str:
    return f"{name} at {number(found.beat)} Hz" if name == BEAT else name


def _columns(shares: Shares) -> list[Bar]:
    """One column for each stretch of the runs, the highest as high as there is room."""
    top = max(shares.values(), default=0.0)
    return [
        Bar(f"stretch {place} of {len(shares)}", percent(share), clamped(share / top) if top > 0 else 0.0)
        for place, share in enumerate(shares.values(), start=1)
    ]


def _pictures(diagnosis: Diagnosis) -> list[Picture]:
    found = diagnosis.residual_force
    if not len(found.force):
        return []
    run, file = worst_residual_run(diagnosis)
    drawings = (
        ("velocity", "Over the sliding velocity: samples, median and middle half", panels.over_velocity),
        ("displacement", "Over displacement, by direction of motion", panels.over_displacement),
        ("plane", "Over the plane of both: median in each cell", panels.over_plane),
        ("time", f"Over time in {file}: median and middle half", partial(panels.over_time, run=run)),
    )
    return [
        Picture(
            words, draw(partial(panel, found=found), f"force-{kind}", f"Residual force. {words}.", height=3.0)
        )
        for kind, words, panel in drawings
    ]
