"""jaxstick fit: the constants of a data set."""

from pathlib import Path

import click

from fitting.settings import Settings
from fitting.show import show_fit
from jaxstick.command import DONE, FAILED, common, rig_option
from jaxstick.deferred import deferred
from jaxstick.output import OutputFolder
from jaxstick.progress_bar import ProgressBar
from jaxstick.record import load_dataset
from jaxstick.terminal import Terminal

effects_at_null = deferred("jaxstick.hypothesis", "effects_at_null")
effects_of = deferred("jaxstick.nominal", "effects_of")
run_fit = deferred("fitting.fit", "fit")
save_fit = deferred("fitting.save", "save_fit")
draw_fit = deferred("fitting.plots.gallery", "draw_fit")

FREEABLE = ("mass", "stiffness", "drive_stiffness", "damping", "drive_damping")


class Horizon(click.ParamType):
    """A number of natural periods, or "record" for whole runs."""

    name = "horizon"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | None:
        """The number; None for whole runs."""
        if value == "record":
            return None
        try:
            periods = float(str(value))
        except ValueError:
            periods = 0.0
        if not 0 < periods < float("inf"):
            self.fail(f"{value!r} is neither a positive number of natural periods nor 'record'", param, ctx)
        return periods


@click.command()
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option(
    "--out", required=True, metavar="DIR", type=click.Path(path_type=Path), help="Folder for the results."
)
@click.option("--overwrite", is_flag=True, help="Replace earlier results of jaxstick in DIR.")
@click.option(
    "--with",
    "effects",
    multiple=True,
    metavar="EFFECT",
    help="Let an effect take part (see jaxstick effects); of the measuring chain in the order given, from "
    "the contact to the record, after those that the rig file states.",
)
@click.option(
    "--free",
    multiple=True,
    type=click.Choice(FREEABLE),
    metavar="PARAMETER",
    help=f"Fit a parameter of the rig too, near its stated value: {', '.join(FREEABLE)}.",
)
@click.option(
    "--horizon",
    type=Horizon(),
    default=str(Settings.horizon),
    show_default=True,
    metavar="PERIODS|record",
    help="Length of the pieces into which runs are cut, in natural periods.",
)
@click.option(
    "--starts",
    type=click.IntRange(min=1),
    default=Settings.starts,
    show_default=True,
    help="Descents to try.",
)
@rig_option
@common
def fit(
    dataset: Path,
    out: Path,
    overwrite: bool,
    effects: tuple[str, ...],
    free: tuple[str, ...],
    horizon: float | None,
    starts: int,
    rig: Path | None,
    terminal: Terminal,
) -> int:
    """Fit A, B, C, D and k1 to the runs of DATASET that are not held out.

    Effects that the rig file states under [effects] act as stated; --with makes them free. DIR gets fit.json,
    the fitted traces of each run as CSV, plots, and corrected_rig.toml, a rig file with what was found. Ends
    with 1 if the search did not converge; its results are written all the same.
    """
    data = load_dataset(dataset, rig)
    if effects:
        effects_at_null(effects)
    if data.effects:
        effects_of(data)
    settings = Settings(horizon=horizon, effects=effects, free=free, starts=starts, seed=terminal.seed)
    bar = ProgressBar(terminal.progress_console())
    with (
        OutputFolder(out, overwrite, inputs=[dataset] if rig is None else [dataset, rig]) as output,
        bar as progress,
    ):
        found = run_fit(data, settings, progress)
        content = save_fit(found, data, output)
        draw_fit(found, output, progress)
    show_fit(content, terminal)
    terminal.say(f"Results are in {out}; corrected_rig.toml is a rig file with what was found.")
    terminal.result(content)
    if content["outcome"] == "converged":
        return DONE
    click.echo(f"jaxstick: the fit in {out} is not to be relied on: {content['outcome']}.", err=True)
    return FAILED
