"""jaxstick simulate: the runs as the assumed constants predict them."""

from pathlib import Path, PurePosixPath
from typing import Any

import click
import numpy as np

from jaxstick.check import quantity
from jaxstick.command import common, rig_option
from jaxstick.cycle import cycle_of, outcome_of
from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.output import OutputFolder
from jaxstick.record import DataSet, Run, load_dataset, load_rig, save_dataset
from jaxstick.terminal import Terminal, stops_text
from jaxstick.version import version

simulations = deferred("jaxstick.simulations", "simulations")
motion = deferred("jaxstick.plots.motion", "motion")
save_figure = deferred("jaxstick.plots.style", "save")

SETTLED = 3
"""How many of the last cycles count in a simulation from rest."""


@click.command()
@click.argument("source", metavar="DATASET|RIG.toml", type=click.Path(path_type=Path))
@click.option(
    "--out", required=True, metavar="DIR", type=click.Path(path_type=Path), help="Folder for the results."
)
@click.option("--overwrite", is_flag=True, help="Replace earlier results of jaxstick in DIR.")
@rig_option
@common
def simulate(source: Path, out: Path, overwrite: bool, rig: Path | None, terminal: Terminal) -> None:
    """Simulate the runs of a data set, or those a rig.toml lists, with the constants under [assumed] and the
    effects under [effects].

    DIR becomes a data set itself: rig.toml and one CSV file per run, besides simulation.json and plots. A
    recorded run is driven as recorded and begins like the record; a run that is only listed begins at rest.
    Nothing here is random.
    """
    sheet = load_rig(source if rig is None else rig)
    recorded = source.is_dir() and any((source / plan.file).exists() for plan in sheet.runs)
    if rig is not None and not recorded:
        raise UserError(f"{source}: this is no folder with a record that {rig} lists, which --rig asks for.")
    given = load_dataset(source, rig) if recorded else sheet
    records = given.runs if isinstance(given, DataSet) else ()
    inputs = [source] if rig is None else [source, rig]
    with OutputFolder(out, overwrite, inputs=inputs) as output:
        simulated = simulations(given)
        words = "assumed constants and effects" if simulated.effects else "assumed constants"
        save_dataset(simulated, output.folder, f"Simulated with the {words} by jaxstick {version()}.")
        entries = []
        for number, run in enumerate(simulated.runs):
            record = records[number] if records else None
            entry = _entry(run, record)
            entries.append(entry)
            name = PurePosixPath("plots", run.file).with_suffix(".png")
            save_figure(motion(run, record, entry["frequency_hz"]), output.path(str(name)))
        result = {
            "schema": 1,
            "runs": entries,
            "data": {"name": given.name, "sha256": given.sha256},
            "version": version(),
        }
        output.write_json("simulation.json", result)
    _show(entries, terminal)
    terminal.say(f"Results are in {out}.")
    terminal.result(result)


def _entry(run: Run, record: Run | None) -> dict[str, Any]:
    cycle = cycle_of(run)
    predicted = outcome_of(run, SETTLED if record is None else None)
    natural = run.rig.natural_frequency
    measured = None if record is None else outcome_of(record)
    return {
        "file": run.file,
        "frequency_hz": None if cycle is None else cycle.frequency,
        "frequency_ratio": cycle.frequency / natural if cycle is not None and natural else None,
        "base_amplitude_m": None if cycle is None else cycle.base_amplitude,
        "samples": len(run.time),
        "amplitude_m": None if predicted is None else predicted.amplitude,
        "stops": None if predicted is None else predicted.stops,
        "stick_fraction": None if predicted is None else predicted.stick_fraction,
        "measured": None
        if record is None
        else {
            "amplitude_m": None if measured is None else measured.amplitude,
            "stops": None if measured is None else measured.stops,
            "rms_displacement_m": _rms(run.displacement - record.displacement),
            "rms_friction_n": None
            if record.friction is None or run.friction is None
            else _rms(run.friction - record.friction),
        },
    }


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _show(entries: list[dict[str, Any]], terminal: Terminal) -> None:
    against = any(entry["measured"] for entry in entries)
    columns = ["run", "drive", "f/fn", "amplitude", "stops a cycle", "at rest"]
    rows = []
    for entry in entries:
        row = [
            entry["file"],
            quantity(entry["frequency_hz"], "Hz"),
            quantity(entry["frequency_ratio"], ""),
            quantity(entry["amplitude_m"], "m"),
            stops_text(entry["stops"]),
            "-" if entry["stick_fraction"] is None else f"{100 * entry['stick_fraction']:.0f} %",
        ]
        measured = entry["measured"]
        if against:
            row += [
                quantity(measured["amplitude_m"], "m"),
                stops_text(measured["stops"]),
                quantity(measured["rms_displacement_m"], "m"),
                quantity(measured["rms_friction_n"], "N"),
            ]
        rows.append(row)
    if against:
        columns += ["recorded", "stops", "gap x (rms)", "gap F (rms)"]
    terminal.table("As the assumed constants predict", columns, rows)
