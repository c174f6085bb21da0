"""jaxstick blind: cases whose effect is withheld."""

from pathlib import Path

import click

from fitting.blind.kinds import FAMILIES, KINDS, MODES, TIERS
from jaxstick.command import DONE, FAILED, common
from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.output import atomic_write_text
from jaxstick.progress_bar import ProgressBar
from jaxstick.terminal import Terminal

make_cases = deferred("fitting.blind.making", "make_cases")
settings_of = deferred("fitting.blind.making", "settings_of")
new_key = deferred("fitting.blind.seal", "new_key")
read_key = deferred("fitting.blind.seal", "read_key")


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
    key_file: Path | None,
    workers: int | None,
    terminal: Terminal,
) -> int:
    """Make N cases in DIR and seal their answers.

    The key opens the answers: keep it away from whoever diagnoses, and the seed as well. A run that was
    stopped is taken up again by the same options, with the same key in the key file. Ends with 1 if a case
    failed.
    """
    key = _key(key_file, out)
    if key_file is None:
        click.echo(f"The key is {key}", err=True)
    bar = ProgressBar(terminal.progress_console())
    settings = settings_of(family, terminal.seed, runs, samples, strength)
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
