"""Figures as SVG inside a page: their colours are the page's, light or dark, and their ids are unique."""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable

from markupsafe import Markup
from matplotlib import rc_context
from matplotlib.axes import Axes

from fitting.plots.residual_force import DIVERGING
from jaxstick.plots.style import SERIES, Margins, framed, legend_above, new_figure, style

COLOURS = {
    "#000000": "ink",
    "#ffffff": "paper",
    "#dddddd": "grid",
    "#4d4d4d": "measured",
    "#a6a6a6": "halo",
    **{colour.lower(): f"series-{number}" for number, colour in enumerate(SERIES[:6])},
    **{colour: f"scale-{number}" for number, colour in enumerate(DIVERGING)},
}
"""The page's variable (--fig-...) for each colour of the house style."""

_SVG = "{http://www.w3.org/2000/svg}"
_HREF = "{http://www.w3.org/1999/xlink}href"
_DECIMALS = re.compile(r"(\.\d)\d+")
_HEX = re.compile(r"#[0-9a-fA-F]{6}\b")
_FONT = re.compile(r"font: ([\d.]+px) [^;]*")
_OWN = re.compile(r"#([\w-]+)")
_SETTINGS = {"svg.fonttype": "none", "path.simplify_threshold": 0.25, "savefig.dpi": 150}

WIDTH, HEIGHT = 4.5, 2.7


def draw(
    panel: Callable[[Axes], None],
    name: str,
    description: str,
    legend: bool = False,
    height: float = HEIGHT,
    margins: Margins | None = None,
) -> Markup:
    """One panel as an `<svg>` element with a title for those who cannot see it.

    name: unique on the page; every id begins with it; margins: where they need not be found from the labels.
    Text stays text, in the page's font.
    """
    with style(), rc_context(_SETTINGS):  # pyright: ignore[reportArgumentType]
        figure = new_figure(WIDTH, height)
        axes = figure.subplots()
        panel(axes)
        if legend:
            legend_above(axes)
        if margins is not None:
            framed(figure, margins)
        stream = io.StringIO()
        no_origin = {"Date": None, "Creator": None, "Format": None, "Type": None}
        figure.savefig(stream, format="svg", transparent=True, metadata=no_origin)
    return Markup(_for_page(stream.getvalue(), name, description))


def _for_page(text: str, name: str, description: str) -> str:
    root = ET.fromstring(text)
    used = {
        found
        for element in root.iter()
        for value in (element.get(_HREF, ""), element.get("clip-path", ""))
        for found in _OWN.findall(value)
    }
    for element in list(root.iter()):
        for metadata in element.findall(f"{_SVG}metadata"):
            element.remove(metadata)
    for element in root.iter():
        element.tag = element.tag.removeprefix(_SVG)
        element.tail = None if not (element.tail or "").strip() else element.tail
        _rename(element, name, used)
        if (look := element.get("style")) is not None:
            look = _FONT.sub(r"font: \1 var(--sans)", look)
            element.set("style", _HEX.sub(_variable, look))
        for attribute in ("d", "x", "y", "transform"):
            if (value := element.get(attribute)) is not None:
                element.set(attribute, _DECIMALS.sub(r"\1", " ".join(value.split())))
    for attribute in ("width", "height", "version"):
        root.attrib.pop(attribute, None)
    title = ET.Element("title", id=f"{name}-title")
    title.text = description
    root.insert(0, title)
    root.set("role", "img")
    root.set("aria-labelledby", f"{name}-title")
    root.set("id", name)
    return ET.tostring(root, encoding="unicode")


def _rename(element: ET.Element, name: str, used: set[str]) -> None:
    """Ids that something refers to begin with `name`; the others go."""
    own = element.attrib.pop("id", None)
    if own in used:
        element.set("id", f"{name}-{own}")
    if (link := element.attrib.pop(_HREF, None)) is not None:
        element.set("href", f"#{name}-{link[1:]}" if link.startswith("#") else link)
    if (clip := element.get("clip-path")) is not None:
        element.set("clip-path", _OWN.sub(rf"#{name}-\1", clip))


def _variable(found: re.Match[str]) -> str:
    colour = found[0].lower()
    return f"var(--fig-{COLOURS[colour]})" if colour in COLOURS else colour
