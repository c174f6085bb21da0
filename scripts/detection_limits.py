"""What a diagnosis of a data set could see: the predicted detection limit of every effect, as a table.

    python -m scripts.detection_limits DATASET ...

The limits that a diagnosis predicts, here from all runs and without looking for a cause: for every strength
of every effect of the shelf, in its usual shape, what the data set would show in nine of ten cases, at the
fitted nominal model with everything free that a diagnosis leaves free; and the effect that is likest to it in
these records, with the cosine between the two.
"""

from __future__ import annotations

from pathlib import Path

import click

from fitting.diagnosis.findings import Limit
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.ground import ground
from fitting.diagnosis.refits.refit import refit
from fitting.diagnosis.refits.release import released
from fitting.diagnosis.which.detection import limits
from fitting.diagnosis.which.screen import screen
from fitting.problem import pose
from fitting.progress import Silent
from fitting.report.words import NOTHING, number
from fitting.settings import Settings
from jaxstick.compilation_cache import set_up_jax
from jaxstick.record import load_dataset


@click.command()
@click.argument("datasets", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
def main(datasets: tuple[Path, ...]) -> None:
    """Print the detection limits of every data set as a table in Markdown."""
    set_up_jax()
    for folder in datasets:
        click.echo(f"\n### {folder.name}\n")
        click.echo(
            "| effect | strength | limit | unit | likest | cosine |\n| --- | --- | ---: | --- | --- | ---: |"
        )
        for limit in predicted(folder):
            row = limit.effect, limit.strength, number(limit.value, 2), limit.unit, limit.likest or NOTHING
            click.echo(f"| {' | '.join((*row, number(limit.cosine)))} |")


def predicted(folder: Path) -> tuple[Limit, ...]:
    """The limits for the data set in a folder."""
    settings = Settings()
    problem = pose(load_dataset(folder), settings)
    model = Model(problem, settings.workers)
    base = ground(problem, model, settings, Silent())
    (nominal,) = refit(model, base.bench, [base.point], [model.nuisances()])
    nominal = released(model, base.bench, nominal)
    seen = screen(model, base.bench, nominal, shapes=[])
    return limits(model, seen, seen.inflation)


if __name__ == "__main__":
    main()
