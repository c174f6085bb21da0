"""The blind check in one command: cases made from a seed, diagnosed, scored against their sealed answers.

    python -m scripts.blind_study --cases 500 --seed S --out out/blind [--strength weak] [--workers 2]

OUT gets cases/, key (of the seal), results/ and score/ with score.json and score.html. The same command goes
on where an earlier one was stopped or killed. Use a seed that was not used while the diagnosis was built: the
default purpose, "judging", has cases of its own for every seed.

Ends with 0 when every case was diagnosed, 1 where some failed (they count as wrong).
"""

from __future__ import annotations

import sys
from pathlib import Path

import click

from fitting.blind.kinds import FAMILIES, KINDS, MODES, TIERS
from fitting.blind.making import make_cases, settings_of
from fitting.blind.seal import MANIFEST, new_key, read_key, read_manifest
from fitting.blind.seeds import seed_checksum
from fitting.blind_run.running import run_cases
from fitting.blind_score.page import score_page
from fitting.blind_score.score import score
from fitting.blind_score.show import show_score
from jaxstick.compilation_cache import set_up_jax
from jaxstick.errors import UserError
from jaxstick.output import OutputFolder, atomic_write_text
from jaxstick.progress_bar import ProgressBar
from jaxstick.terminal import Terminal


@click.command()
@click.option("--cases", default=500, show_default=True, type=click.IntRange(1, 9999), help="How many.")
@click.option("--seed", required=True, type=click.IntRange(min=0), help="Seed of the cases.")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for everything.")
@click.option("--family", default=FAMILIES[-1], type=click.Choice(FAMILIES), help="Purpose of the cases.")
@click.option("--strength", default=MODES[0], type=click.Choice(MODES), help="How strongly effects act.")
@click.option("--kind", "kinds", default=",".join(KINDS), show_default=True, help="Kinds, between commas.")
@click.option("--tiers", default=",".join(TIERS), show_default=True, help="Tiers, between commas.")
@click.option("--runs", default=6, show_default=True, type=click.IntRange(2, 20), help="Runs in a case.")
@click.option("--samples", default=8000, show_default=True, type=click.IntRange(min=400), help="In a case.")
@click.option("--workers", type=click.IntRange(min=1), help="Processes (all cores).")
@click.option("--scheduler", help="Address of a Dask scheduler whose workers diagnose.")
def main(
    cases: int,
    seed: int,
    out: Path,
    family: str,
    strength: str,
    kinds: str,
    tiers: str,
    runs: int,
    samples: int,
    workers: int | None,
    scheduler: str | None,
) -> None:
    """Make, diagnose and score CASES cases of SEED."""
    set_up_jax()
    terminal = Terminal()
    folder, results = out / "cases", out / "results"
    out.mkdir(parents=True, exist_ok=True)
    key = _key(out / "key")
    with ProgressBar(terminal.progress_console(), remaining=True) as progress:
        if not (folder / MANIFEST).exists():
            make_cases(
                folder,
                cases,
                settings_of(family, seed, runs, samples, strength),
                key,
                progress,
                kinds=_some(kinds, KINDS),
                tiers=_some(tiers, TIERS),
                workers=workers,
            )
        elif read_manifest(folder)["seed_sha256"] != seed_checksum(family, seed):
            raise UserError(f"{folder}: the cases in it are of another seed; name another folder.")
        ran = run_cases(folder, results, progress, workers=workers, scheduler=scheduler)
    found = score(folder, results, key)
    with OutputFolder(out / "score", overwrite=True) as output:
        output.write_json("score.json", found)
        output.write_text("score.html", score_page(found))
    show_score(found, terminal)
    terminal.say(f"The page is {out / 'score' / 'score.html'}; score.json lies beside it.")
    sys.exit(1 if ran.failed else 0)


def _key(path: Path) -> str:
    """The key in the file, or a new one written to it."""
    if not path.exists():
        atomic_write_text(path, new_key() + "\n")
    return read_key(path)


def _some(given: str, words: tuple[str, ...]) -> tuple[str, ...]:
    """The words among those given, in our order; raises UserError for one that is not ours."""
    asked = [word.strip() for word in given.split(",")]
    for word in asked:
        if word not in words:
            raise UserError(f"{word!r} is none of {', '.join(words)}.")
    return tuple(word for word in words if word in asked)


if __name__ == "__main__":
    try:
        main()
    except UserError as mistake:
        click.echo(f"blind_study: {mistake}", err=True)
        sys.exit(2)
