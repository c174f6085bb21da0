"""jaxstick diagnose: where simulation and record part, which effect causes it, how far the gap closes."""

from pathlib import Path

import click

from fitting.aside import Aside
from fitting.diagnosis.settings import DiagnosisSettings
from fitting.progress import Silent
from jaxstick.command import DONE, common, rig_option
from jaxstick.deferred import deferred
from jaxstick.output import OutputFolder, plain
from jaxstick.progress_bar import ProgressBar
from jaxstick.record import load_dataset
from jaxstick.terminal import Terminal

run_diagnosis = deferred("fitting.diagnosis.diagnose", "diagnose")
save_diagnosis = deferred("fitting.diagnosis.save", "save_diagnosis")
draw_diagnosis = deferred("fitting.plots.diagnosis_gallery", "draw_diagnosis")
write_report = deferred("fitting.report.report", "write_report")
show_diagnosis = deferred("fitting.show_diagnosis", "show_diagnosis")


@click.command()
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option(
    "--out", required=True, metavar="DIR", type=click.Path(path_type=Path), help="Folder for the results."
)
@click.option("--overwrite", is_flag=True, help="Replace earlier results of jaxstick in DIR.")
@click.option(
    "--hold-out",
    multiple=True,
    metavar="FILE",
    help="Keep a run for judging, besides those that rig.toml holds out.",
)
@rig_option
@common
def diagnose(
    dataset: Path,
    out: Path,
    overwrite: bool,
    hold_out: tuple[str, ...],
    rig: Path | None,
    terminal: Terminal,
) -> int:
    """Say where the simulation and the records of DATASET part, which effect causes it and how far it closes.

    DIR gets report.html, diagnosis.json, plots and, where an effect is named and the contact is as assumed,
    corrected_rig.toml: a rig file with the effect in.
    """
    data = load_dataset(dataset, rig)
    settings = DiagnosisSettings(hold_out=hold_out, seed=terminal.seed)
    settings.held_out(data)
    bar = ProgressBar(terminal.progress_console())
    with (
        OutputFolder(out, overwrite, inputs=[dataset] if rig is None else [dataset, rig]) as output,
        bar as progress,
        Aside(draw_diagnosis) as drawing,
    ):
        found = run_diagnosis(data, settings, progress)
        content = save_diagnosis(found, data, output)
        drawing.begin(found, data, output, Silent())
        write_report(found, data, output, progress)
        progress.stage("plots", 1)
        drawing.end()
        progress.advance()
    show_diagnosis(plain(content), terminal)
    terminal.say(f"The report is {out / 'report.html'}; results and plots lie beside it.")
    if found.correction is not None:
        terminal.say(f"The model with the named effects is kept in {out / 'corrected_rig.toml'}.")
    terminal.result(content)
    return DONE
