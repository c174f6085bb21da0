"""A record of a blind run as tables in Markdown: its figures by tier, and how often each effect was named.

python -m scripts.blind_table data/blind/strong-84/score.json
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

import click

from fitting.blind_score.rows import (
    EFFECT_COLUMNS,
    answer_columns,
    answer_rows,
    effect_rows,
    further_columns,
    further_rows,
)


@click.command()
@click.argument("score", type=click.Path(exists=True, dir_okay=False, path_type=Path))
def main(score: Path) -> None:
    """Print the figures of a score.json and its effects."""
    found = json.loads(score.read_text(encoding="utf-8"))
    click.echo(table(answer_columns(found), answer_rows(found)))
    click.echo()
    click.echo(table(further_columns(found), further_rows(found)))
    click.echo()
    click.echo(table(EFFECT_COLUMNS, effect_rows(found)))


def table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """The rows under these columns."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)


if __name__ == "__main__":
    main()
