"""A score as one page that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from fitting.blind_score.pictures import pictures
from fitting.blind_score.rows import sentence
from fitting.blind_score.tables import tables
from fitting.report.words import tied

_TEMPLATE = Path(__file__).parent / "page.html"


def score_page(score: Mapping[str, Any]) -> str:
    """The page as text: tables and pictures of a score; whatever comes from files is escaped."""
    environment = jinja2.Environment(
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=lambda value: tied(value) if type(value) is str else value,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    look = (files("fitting.report") / "templates" / "look.css").read_text(encoding="utf-8")
    return environment.from_string(_TEMPLATE.read_text(encoding="utf-8")).render(
        score=score,
        sentence=sentence(score),
        tables=tables(score),
        pictures=list(pictures(score)),
        look=Markup(look),
    )
