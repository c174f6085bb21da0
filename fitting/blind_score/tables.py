"""The tables of a score, as terminal, page and records show them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from fitting.blind_score.rows import (
    CONFUSION_COLUMNS,
    CONSTANT_COLUMNS,
    EFFECT_COLUMNS,
    MISTAKE_COLUMNS,
    RELIABILITY_COLUMNS,
    RIG_COLUMNS,
    Row,
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
)


class Table(NamedTuple):
    """A table: its key, its title, and what it holds."""

    key: str
    title: str
    columns: Row
    rows: list[Row]


def tables(score: Mapping[str, Any]) -> list[Table]:
    """The tables of a score that hold anything, in order."""
    every = (
        Table("answers", "Answers, with 95 % intervals", answer_columns(score), answer_rows(score)),
        Table("further", "Calibration, intervals, closure", further_columns(score), further_rows(score)),
        Table(
            "reliability-table",
            "Reliability of the likeliest answer",
            RELIABILITY_COLUMNS,
            reliability_rows(score),
        ),
        Table("effects", "Effects that acted alone", EFFECT_COLUMNS, effect_rows(score)),
        Table("rigs", "Right verdicts by rig", RIG_COLUMNS, rig_rows(score)),
        Table("constants", "Constants, tier A", CONSTANT_COLUMNS, constant_rows(score)),
        Table("taken-for", "What was taken for what", CONFUSION_COLUMNS, confusion_rows(score)),
        Table("mistakes", "Verdicts that were wrong", MISTAKE_COLUMNS, mistake_rows(score)),
    )
    return [table for table in every if table.rows]
