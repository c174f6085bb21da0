"""Records of several blind runs counted together, as a table in Markdown.

python -m scripts.blind_totals data/blind/strong-200/score.json data/blind/strong-124/score.json ...
"""

from __future__ import annotations

import collections
import itertools
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from fitting.blind_score.intervals import Figure, share
from fitting.blind_score.rows import ANSWERS, FURTHER
from scripts.blind_table import table

Tier = Mapping[str, Any]
TITLES = {key: title for key, title, _ in ANSWERS}
COUNTED = ("parameters", "constants", "constants_before", "covered", "margin", "named_beyond_predicted")
SHARES: tuple[tuple[str, str, Callable[[Tier], Figure | None]], ...] = (
    *((title, asked, lambda tier, key=key: tier[key]) for key, title, asked in ANSWERS),
    *((each.title, each.asked, each.of) for each in (FURTHER[key] for key in COUNTED)),
)
"""What a share says, what is asked for, and where a tier of a score has it."""
MEANS: tuple[tuple[str, str, Callable[[Tier], Figure]], ...] = (
    (TITLES["probability"], "≥ 0.90", lambda tier: tier["probability"]),
    FURTHER["log_loss"][:3],
)
"""The same of means over cases."""
TOGETHER = {"all": ("A", "B", "C"), "A and B": ("A", "B"), "C": ("C",)}
OFTEN = 0.9


@click.command()
@click.argument(
    "scores", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
def main(scores: Sequence[Path]) -> None:
    """Print the shares and means of several score.json together."""
    found = [json.loads(score.read_text(encoding="utf-8")) for score in scores]
    click.echo(table(("figure", "asked for", *TOGETHER), rows(found)))


def rows(scores: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """A row for every figure that any of the scores has."""
    tiers = {
        name: [score["tiers"][tier] for score in scores for tier in members if tier in score["tiers"]]
        for name, members in TOGETHER.items()
    }
    counted = [
        (title, asked, *(_share(map(of, each)) for each in tiers.values())) for title, asked, of in SHARES
    ]
    means = [(title, asked, *(_mean(map(of, each)) for each in tiers.values())) for title, asked, of in MEANS]
    named = FURTHER["effects_beyond_predicted"]
    effects = named.title, named.asked, _effects(scores), *("-" for _ in range(len(TOGETHER) - 1))
    every = [*counted, *means, effects]
    return [row for row in every if row[2] != "-"]


def _share(figures: Iterable[Figure | None]) -> str:
    known = [figure for figure in figures if figure is not None and "hits" in figure]
    hits, n = (sum(figure[what] for figure in known) for what in ("hits", "n"))
    return _words(share(number < hits for number in range(n)))


def _words(found: Figure) -> str:
    if not found["n"]:
        return "-"
    value, low, high = (f"{100 * found[what]:.1f}" for what in ("value", "low", "high"))
    return f"{found['hits']} of {found['n']} = {value} % ({low} to {high})"


def _mean(figures: Iterable[Figure]) -> str:
    known = [figure for figure in figures if figure["n"]]
    n = sum(figure["n"] for figure in known)
    return f"{sum(figure['n'] * figure['value'] for figure in known) / n:.3f}" if n else "-"


def _effects(scores: Sequence[Mapping[str, Any]]) -> str:
    """Of the effects that acted alone and were strong enough, how many were named nearly always."""
    hits: collections.Counter[str] = collections.Counter()
    n: collections.Counter[str] = collections.Counter()
    for key, one in itertools.chain.from_iterable(score["effects"].items() for score in scores):
        figure = one.get("named_beyond_predicted")
        if figure is not None:
            hits[key] += figure["hits"]
            n[key] += figure["n"]
    return _words(share(hits[key] >= OFTEN * n[key] for key in n if n[key]))


if __name__ == "__main__":
    main()
