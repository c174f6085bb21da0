"""A score as one page that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from fitting.blind_score.pictures import pictures
from fitting.blind_score.rows import (
    CONFUSION_COLUMNS,
    CONSTANT_COLUMNS,
    EFFECT_COLUMNS,
    MISTAKE_COLUMNS,
    RELIABILITY_COLUMNS,
    RIG_COLUMNS,
    answer_columns,
    answer_rows,
    confusion_rows,
    constant_rows,
    effect_rows,
    further_columns,
    further_rows,
    mistake_rows,
    reliability_rows,
    rig_rows,
    sentence,
)
from fitting.report.words import tied

_TEMPLATE = Path(__file__).parent / "page.html"


def score_page(score: Mapping[str, Any]) -> str:
    """The page as text: tables and pictures of a score; whatever comes from files is escaped."""
    tables = [
        ("answers", "Answers", answer_columns(score), answer_rows(score)),
        ("further", "Calibration, intervals, closure", further_columns(score), further_rows(score)),
        (
            "reliability-table",
            "Reliability of the likeliest answer",
            RELIABILITY_COLUMNS,
            reliability_rows(score),
        ),
        ("effects", "Effects that acted alone", EFFECT_COLUMNS, effect_rows(score)),
        ("rigs", "Right verdicts by rig", RIG_COLUMNS, rig_rows(score)),
        ("constants", "Constants, tier A", CONSTANT_COLUMNS, constant_rows(score)),
        ("taken-for", "What was taken for what", CONFUSION_COLUMNS, confusion_rows(score)),
        ("mistakes", "Verdicts that were wrong", MISTAKE_COLUMNS, mistake_rows(score)),
    ]
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
        tables=[table for table in tables if table[3]],
        pictures=list(pictures(score)),
        look=Markup(look),
    )
