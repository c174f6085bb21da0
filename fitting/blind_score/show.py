"""A score on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fitting.blind_score.rows import (
    CONFUSION_COLUMNS,
    CONSTANT_COLUMNS,
    EFFECT_COLUMNS,
    RELIABILITY_COLUMNS,
    RIG_COLUMNS,
    answer_columns,
    answer_rows,
    confusion_rows,
    constant_rows,
    effect_rows,
    further_columns,
    further_rows,
    reliability_rows,
    rig_rows,
    sentence,
)
from jaxstick.terminal import Terminal


def show_score(score: Mapping[str, Any], terminal: Terminal) -> None:
    """Prints the tables of a score, and what is missing."""
    for title, columns, rows in (
        ("Answers, with 95 % intervals", answer_columns(score), answer_rows(score)),
        ("Calibration, intervals, closure", further_columns(score), further_rows(score)),
        ("Reliability of the likeliest answer", RELIABILITY_COLUMNS, reliability_rows(score)),
        ("Effects that acted alone", EFFECT_COLUMNS, effect_rows(score)),
        ("Right verdicts by rig", RIG_COLUMNS, rig_rows(score)),
        ("Constants, tier A", CONSTANT_COLUMNS, constant_rows(score)),
        ("What was taken for what", CONFUSION_COLUMNS, confusion_rows(score)),
    ):
        if rows:
            terminal.table(title, columns, rows)
    if score["missing"]:
        terminal.say(f"{len(score['missing'])} cases have no diagnosis and count as wrong:", "bold")
        terminal.bullets(f"{case}: {reason}" for case, reason in score["missing"].items())
    terminal.say(sentence(score), "bold")
