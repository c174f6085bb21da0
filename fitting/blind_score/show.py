"""A score on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fitting.blind_score.rows import sentence
from fitting.blind_score.tables import tables
from jaxstick.terminal import Terminal


def show_score(score: Mapping[str, Any], terminal: Terminal) -> None:
    """Prints the tables of a score but for the wrong verdicts, and what is missing."""
    for table in tables(score):
        if table.key != "mistakes":
            terminal.table(table.title, table.columns, table.rows)
    if score["missing"]:
        terminal.say(f"{len(score['missing'])} cases have no diagnosis and count as wrong:", "bold")
        terminal.bullets(f"{case}: {reason}" for case, reason in score["missing"].items())
    terminal.say(sentence(score), "bold")
