"""jaxstick check: what is in a data set, what is missing, the noise found."""

from pathlib import Path

import click

from jaxstick.check import describe
from jaxstick.command import common
from jaxstick.deferred import deferred
from jaxstick.record import load_dataset
from jaxstick.terminal import Terminal

effects_of = deferred("jaxstick.nominal", "effects_of")

_STYLES = {"missing": "", "warning": "yellow", "notice": "dim"}


@click.command()
@click.argument("dataset", type=click.Path(path_type=Path))
@common
def check(dataset: Path, terminal: Terminal) -> None:
    """Say what DATASET holds, what it lacks and what that costs, and the noise found in it.

    DATASET is a folder with rig.toml and one CSV file per run.
    """
    data = load_dataset(dataset)
    if data.effects:
        effects_of(data)
    description = describe(data)
    for section in description.sections:
        terminal.table(section.title, section.columns, section.rows)
    for kind, style in _STYLES.items():
        sentences = [finding.text for finding in description.findings if finding.kind == kind]
        if sentences:
            terminal.say(kind.capitalize(), "bold")
            terminal.bullets(sentences, style)
    if not any(finding.kind == "warning" for finding in description.findings):
        terminal.say("Nothing here stands in the way of a fit.")
    terminal.result(description)
