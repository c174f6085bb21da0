"""jaxstick blind: cases whose effect is withheld."""

from pathlib import Path
from typing import Any

import click

from fitting.blind.kinds import FAMILIES, KINDS, MODES, TIERS
from fitting.blind_run.results import default_results
from jaxstick.command import DONE, FAILED, common
from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.output import OutputFolder, atomic_write_text
from jaxstick.progress_bar import ProgressBar
from jaxstick.sweeps.lost import ClusterLostError
from jaxstick.terminal import Terminal

make_cases = deferred("fitting.blind.making", "make_cases")
settings_of = deferred("fitting.blind.making", "settings_of")
new_key = deferred("fitting.blind.seal", "new_key")
read_key = deferred("fitting.blind.seal", "read_key")
run_cases = deferred("fitting.blind_run.running", "run_cases")
score_cases = deferred("fitting.blind_score.score", "score")
score_page = deferred("fitting.blind_score.page", "score_page")
show_score = deferred("fitting.blind_score.show", "show_score")

MOST_SAID = 10
"""Failures that are told one by one."""


class Listed(click.ParamType):
    """Some of a few words, between commas."""

    name = "list"

    def __init__(self, words: tuple[str, ...]) -> None:
        self._words = words

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """The words, each once, in our order."""
        if isinstance(value, tuple):
            return value
        given = [word.strip() for word in str(value).split(",")]
        for word in given:
            if word not in self._words:
                self.fail(f"{word!r} is none of {', '.join(self._words)}", param, ctx)
        return tuple(word for word in self._words if word in given)


class Numbers(click.ParamType):
    """Whole numbers and ranges of them, between commas: 1-20,33."""

    name = "numbers"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, ...]:
        """Every number once, in order."""
        if isinstance(value, tuple):
            return value
        found: set[int] = set()
        for part in str(value).split(","):
            low, dash, high = part.strip().partition("-")
            if not (low.isdecimal() and (high.isdecimal() or not dash)) or len(part) > 20:
                self.fail(f"{part.strip()[:40]!r} is neither a number nor a range such as 1-20", param, ctx)
            first, last = int(low), int(high or low)
            if not 1 <= first <= last <= 9999:
                self.fail(f"{part.strip()!r} is no range within 1-9999", param, ctx)
            found.update(range(first, last + 1))
        return tuple(sorted(found))


@click.group()
def blind() -> None:
    """Cases whose effect is withheld: make them, diagnose them, score the diagnosis."""


@blind.command()
@click.option("--cases", required=True, type=click.IntRange(1, 9999), metavar="N", help="How many.")
@click.option(
    "--out", required=True, metavar="DIR", type=click.Path(path_type=Path), help="Folder for the cases."
)
@click.option("--tiers", type=Listed(TIERS), default=TIERS, metavar="A,B,C", help="Tiers that take part.")
@click.option(
    "--kind",
    "kinds",
    type=Listed(KINDS),
    default=KINDS,
    metavar="KINDS",
    help=f"Kinds of cases, of {', '.join(KINDS)}; in the proportions 400:300:120:100.",
)
@click.option("--strength", type=click.Choice(MODES), default=MODES[0], help="How strongly effects act.")
@click.option(
    "--family",
    type=click.Choice(FAMILIES),
    default=FAMILIES[-1],
    help="What the cases are for: the same seed gives each purpose other cases.",
)
@click.option("--runs", type=click.IntRange(2, 20), default=6, show_default=True, help="Runs in a case.")
@click.option(
    "--samples",
    type=click.IntRange(400, 1_000_000),
    default=8000,
    show_default=True,
    help="Samples in a case, about.",
)
@click.option(
    "--spike-on",
    multiple=True,
    metavar="DATASET",
    type=click.Path(path_type=Path),
    help="Put known faults on these records instead (tier D).",
)
@click.option(
    "--spike-times",
    nargs=2,
    type=click.FloatRange(min=0, min_open=True),
    metavar="LOW HIGH",
    help="How many times a channel's noise these change it by (3 30; 0.5 8 where weak).",
)
@click.option(
    "--key-file",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="Where the key is written, or read from if it exists; without it the key is printed.",
)
@click.option("--workers", type=click.IntRange(min=1), metavar="N", help="Processes (all cores).")
@common
def make(
    cases: int,
    out: Path,
    tiers: tuple[str, ...],
    kinds: tuple[str, ...],
    strength: str,
    family: str,
    runs: int,
    samples: int,
    spike_on: tuple[Path, ...],
    spike_times: tuple[float, float] | None,
    key_file: Path | None,
    workers: int | None,
    terminal: Terminal,
) -> int:
    """Make N cases in DIR and seal their answers.

    The key opens the answers: keep it away from whoever diagnoses, and the seed as well. A run that was
    stopped is taken up again by the same options, with the same key in the key file. Ends with 1 if a case
    failed.
    """
    if spike_times is not None and not (spike_on and spike_times[0] <= spike_times[1]):
        low, high = spike_times
        raise UserError(
            f"--spike-times {low:g} {high:g}: expected are a lower and an upper number, and --spike-on."
        )
    key = _key(key_file, out)
    if key_file is None:
        click.echo(f"The key is {key}", err=True)
    bar = ProgressBar(terminal.progress_console())
    settings = settings_of(family, terminal.seed, runs, samples, strength, spike_times)
    choices = {"kinds": kinds, "tiers": tiers, "spike_on": spike_on, "workers": workers}
    try:
        with bar as progress:
            made = make_cases(out, cases, settings, key, progress, **choices)
    except KeyboardInterrupt:
        click.echo(
            f"jaxstick: stopped; the same command with this key in --key-file goes on in {out}.", err=True
        )
        return FAILED
    terminal.say(f"{made.cases} cases are in {out}, sealed.")
    terminal.result({"cases": made.cases, "failed": made.failed, "new": made.new})
    if not made.failed:
        return DONE
    name, reason = next(iter(made.failed.items()))
    click.echo(f"jaxstick: {len(made.failed)} cases failed, the first, {name}, by {reason}.", err=True)
    return FAILED


def _key(key_file: Path | None, out: Path) -> str:
    """The key in the file, or a new one, which is written to it before the first case is made."""
    if key_file is None:
        return new_key()
    if out.resolve() in key_file.resolve().parents:
        raise UserError(f"{key_file}: the key may not lie in the folder of the cases.")
    if key_file.exists():
        return read_key(key_file)
    key = new_key()
    atomic_write_text(key_file, key + "\n")
    return key


@blind.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "--out", metavar="DIR", type=click.Path(path_type=Path), help="Folder for the results (DIR-results)."
)
@click.option("--cases", "numbers", type=Numbers(), metavar="1-20,33", help="These cases only.")
@click.option("--workers", type=click.IntRange(min=1), metavar="N", help="Processes (all cores).")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Let the workers of a Dask scheduler diagnose, e.g. tcp://10.0.0.5:8786.",
)
@click.option("--overwrite", is_flag=True, help="Discard the results that are there.")
@common
def run(
    folder: Path,
    out: Path | None,
    numbers: tuple[int, ...] | None,
    workers: int | None,
    scheduler: str | None,
    overwrite: bool,
    terminal: Terminal,
) -> int:
    """Diagnose the cases in DIR.

    Every case gets a folder with its diagnosis.json beside DIR, never in it. A run that was stopped or killed
    goes on by the same command; cases that failed are tried again. Ends with 1 if a case failed.
    """
    results = default_results(folder) if out is None else out
    bar = ProgressBar(terminal.progress_console(), remaining=True)
    options: dict[str, Any] = {"seed": terminal.seed, "workers": workers, "numbers": numbers}
    try:
        with bar as progress:
            ran = run_cases(folder, results, progress, scheduler=scheduler, overwrite=overwrite, **options)
    except (KeyboardInterrupt, ClusterLostError) as stop:
        why = str(stop) or "stopped before it was done"
        click.echo(f"jaxstick: {results}: {why}; the same command goes on from there.", err=True)
        return FAILED
    if ran.before:
        terminal.say(f"{ran.before} of {ran.cases} cases were diagnosed already.")
    terminal.say(f"{ran.before + ran.new} of {ran.cases} diagnoses are in {results}.")
    terminal.result({"cases": ran.cases, "before": ran.before, "new": ran.new, "failed": ran.failed})
    for name, reason in list(ran.failed.items())[:MOST_SAID]:
        click.echo(f"jaxstick: {name}: {reason}", err=True)
    if len(ran.failed) > MOST_SAID:
        click.echo(f"jaxstick: {len(ran.failed) - MOST_SAID} more cases failed.", err=True)
    return FAILED if ran.failed else DONE


@blind.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--key", metavar="K", help="The key that `jaxstick blind make` gave.")
@click.option(
    "--key-file", metavar="FILE", type=click.Path(path_type=Path), help="The file that holds the key."
)
@click.option(
    "--results", metavar="DIR", type=click.Path(path_type=Path), help="Folder of the results (DIR-results)."
)
@click.option(
    "--out", metavar="DIR", type=click.Path(path_type=Path), help="Folder for score.json and score.html."
)
@click.option("--cases", "numbers", type=Numbers(), metavar="1-20,33", help="These cases only.")
@click.option("--overwrite", is_flag=True, help="Replace earlier results of jaxstick in the --out folder.")
@common
def score(
    folder: Path,
    key: str | None,
    key_file: Path | None,
    results: Path | None,
    out: Path | None,
    numbers: tuple[int, ...] | None,
    overwrite: bool,
    terminal: Terminal,
) -> int:
    """Open the seal of DIR and score its diagnoses.

    Every figure comes with its 95 % interval, beside chance and two simple diagnosers. A case without a
    diagnosis counts as wrong; of a run that is not over, --cases scores those that it has been through.
    """
    if (key is None) == (key_file is None):
        raise UserError("The key is given by --key or by --key-file, one of the two.")
    opening = read_key(key_file) if key_file is not None else key
    place = default_results(folder) if results is None else results
    found = score_cases(folder, place, opening, numbers)
    if out is not None:
        with OutputFolder(out, overwrite, inputs=[folder]) as output:
            output.write_json("score.json", found)
            output.write_text("score.html", score_page(found))
    show_score(found, terminal)
    if out is not None:
        terminal.say(f"The page is {out / 'score.html'}; score.json lies beside it.")
    terminal.result(found)
    return DONE
