"""What a diagnosis of a data set could see: the predicted detection limit of every effect, as a table.

    python -m scripts.detection_limits DATASET ...

For every effect of the shelf, in its usual shape, the strength that the data set would show in nine of ten
cases, at the fitted nominal model with everything free that a diagnosis leaves free; and the effect that is
likest to it in these records, with the cosine between the two.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from fitting.diagnosis.detection import detection_limit
from fitting.diagnosis.ground import ground
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import refit
from fitting.diagnosis.release import released
from fitting.diagnosis.screen import screen
from fitting.problem import pose
from fitting.progress import Silent
from fitting.settings import Settings
from jaxstick.compilation_cache import keep_compiled
from jaxstick.record import load_dataset


@click.command()
@click.argument("datasets", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
def main(datasets: tuple[Path, ...]) -> None:
    """Print the detection limits of every data set as a table in Markdown."""
    keep_compiled()
    for folder in datasets:
        click.echo(f"\n### {folder.name}\n")
        click.echo(
            "| effect | strength | limit | unit | likest | cosine |\n| --- | --- | ---: | --- | --- | ---: |"
        )
        for row in rows(folder):
            click.echo(f"| {' | '.join(row)} |")


def rows(folder: Path) -> list[tuple[str, ...]]:
    """Effect, strength, limit, unit, likest effect and the cosine with it, for the data set in a folder."""
    settings = Settings()
    problem = pose(load_dataset(folder), settings)
    model = Model(problem, settings.workers)
    base = ground(problem, model, settings, Silent())
    (nominal,) = refit(model, base.bench, [base.point], [model.nuisances()])
    nominal = released(model, base.bench, nominal)
    seen = screen(model, base.bench, nominal, shapes=[])
    inflation = float(np.median([promise.inflation for promise in seen.promises]))
    found = []
    for promise in sorted(seen.promises, key=lambda promise: promise.key):
        strength = model.shelf.strengths[promise.key][0]
        cosines = (
            seen.cosine[seen.keys.index(promise.key)] - np.eye(len(seen.keys))[seen.keys.index(promise.key)]
        )
        likest = int(np.argmax(cosines))
        limit = detection_limit(model, promise, inflation)
        unit = model.members[model.index(strength)[0]].unit
        name = strength.partition(".")[2]
        found.append((promise.key, name, f"{limit:.2g}", unit, seen.keys[likest], f"{cosines[likest]:.3f}"))
    return found


if __name__ == "__main__":
    main()
