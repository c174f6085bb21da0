"""A record of a blind run as tables in Markdown: its figures by tier, by effect and by rig.

python -m scripts.blind_table data/blind/strong-84/score.json
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

import click

from fitting.blind_score.tables import tables

SHOWN = ("answers", "further", "effects", "rigs")
"""The tables that are printed, by their keys."""


@click.command()
@click.argument("score", type=click.Path(exists=True, dir_okay=False, path_type=Path))
def main(score: Path) -> None:
    """Print the figures of a score.json, its effects and its rigs."""
    found = json.loads(score.read_text(encoding="utf-8"))
    click.echo("\n\n".join(table(each.columns, each.rows) for each in tables(found) if each.key in SHOWN))


def table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """The rows under these columns."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)


if __name__ == "__main__":
    main()
