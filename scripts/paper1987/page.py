"""The page: figures and findings as one HTML file that needs no other."""

import base64
import html
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from scripts.paper1987.claims import (
    AGREES,
    DIFFERS,
    OPEN,
    PARTLY,
    Finding,
    StopsRow,
    changes,
    other_minima,
)
from scripts.paper1987.states import Curve

MOST_LISTED = 8

_COLOURS = {AGREES: "#009E73", PARTLY: "#E69F00", DIFFERS: "#D55E00", OPEN: "#666666"}

_STYLE = """
body { font: 16px/1.5 Georgia, "DejaVu Serif", serif; color: #222; }
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; } h2 { font-size: 1.2rem; margin-top: 2.4rem; }
figure { margin: 1rem 0 1.6rem; } figure img { width: 100%; height: auto; }
figcaption, table { font: 14px/1.45 Helvetica, Arial, 'DejaVu Sans', sans-serif; }
table { border-collapse: collapse; margin: 0.8rem 0 1.4rem; }
th, td { text-align: left; vertical-align: top; padding: 0.3rem 0.9rem 0.3rem 0; }
th, td { border-bottom: 1px solid #ddd; }
th { border-bottom: 1px solid #888; }
table.findings { width: 100%; } table.findings th:first-child { width: 34%; }
.verdict { font-weight: bold; white-space: nowrap; }
"""


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure under its caption."""

    figure: Figure
    caption: str


@dataclass(frozen=True)
class Rows:
    """A table: its column heads and its cells as text."""

    heads: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Section:
    """A heading and below it paragraphs (text), pictures, tables and findings, in their order."""

    heading: str
    parts: Sequence[str | Picture | Rows | Sequence[Finding]]


def page(title: str, opening: Iterable[str], sections: Iterable[Section]) -> str:
    """The whole page as HTML."""
    lines = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style></head><body>",
        f"<h1>{html.escape(title)}</h1>",
        *(f"<p>{html.escape(text)}</p>" for text in opening),
    ]
    for section in sections:
        lines.append(f"<h2>{html.escape(section.heading)}</h2>")
        lines += [_part(part) for part in section.parts]
    return "\n".join([*lines, "</body></html>", ""])


def stops_table(rows: Sequence[StopsRow], ratios: Sequence[float], head: str) -> Rows:
    """Stops a cycle at the five ratios, one assumption a row."""
    return Rows(
        (head, *(f"{ratio:g}" for ratio in ratios), "as the paper"),
        tuple(
            (row.assumption, *(f"{number:.3g}" for number in row.stops), "yes" if row.agrees else "no")
            for row in rows
        ),
    )


def changes_table(curves: Sequence[Curve]) -> Rows:
    """Where the number of stops changes on each curve, with the local minimum that falls there."""
    pairs = [(stops, stops - 2) for stops in range(10, 1, -2)]
    cells = []
    for curve in curves:
        found = {change.below: change for change in changes(curve)}
        row = [curve.label]
        for stops, _ in pairs:
            change = found.get(stops)
            low = "-" if change is None else f"{change.minimum:.3f}" if change.meets else "none"
            row.append("-" if change is None else f"{change.place:.3f} ({low})")
        others = other_minima(curve)
        row.append(
            f"{len(others)} from {others[0]:.3f} to {others[-1]:.3f}"
            if len(others) > MOST_LISTED
            else ", ".join(f"{place:.3f}" for place in others) or "none"
        )
        cells.append(tuple(row))
    heads = [f"{below} to {above}" for below, above in pairs]
    return Rows(("stops change at f/fn (minimum there)", *heads, "other minima"), tuple(cells))


def _part(part: str | Picture | Rows | Sequence[Finding]) -> str:
    if isinstance(part, str):
        return f"<p>{html.escape(part)}</p>"
    if isinstance(part, Picture):
        return (
            f'<figure><img alt="{html.escape(part.caption, quote=True)}" '
            f'src="data:image/png;base64,{_png(part.figure)}">'
            f"<figcaption>{html.escape(part.caption)}</figcaption></figure>"
        )
    if isinstance(part, Rows):
        head = "".join(f"<th>{html.escape(cell)}</th>" for cell in part.heads)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in part.cells
        )
        return f"<table><tr>{head}</tr>{body}</table>"
    rows = "".join(
        f"<tr><td>{html.escape(finding.claim)}</td>"
        f'<td class="verdict" style="color:{_COLOURS[finding.verdict]}">{html.escape(finding.verdict)}</td>'
        f"<td>{html.escape(finding.found)}</td></tr>"
        for finding in part
    )
    return f'<table class="findings"><tr><th>The paper</th><th></th><th>Computed</th></tr>{rows}</table>'


def _png(figure: Figure) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=150, metadata={"Software": None})
    return base64.b64encode(buffer.getvalue()).decode("ascii")
