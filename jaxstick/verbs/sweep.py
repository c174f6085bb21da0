"""jaxstick sweep: periodic states over frequency, base amplitude and the constants of friction."""

import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from jaxstick.command import DONE, FAILED, common
from jaxstick.deferred import deferred
from jaxstick.output import OutputFolder, atomic_writer
from jaxstick.progress_bar import ProgressBar
from jaxstick.record import CONSTANTS, load_rig
from jaxstick.sweeps.engine import CHUNK, computing, finish
from jaxstick.sweeps.field import Field, FieldBuilder, curves, said
from jaxstick.sweeps.lost import ClusterLostError
from jaxstick.sweeps.plan import AXES, Plan, plan_sweep
from jaxstick.sweeps.regions import regions
from jaxstick.sweeps.store import Store
from jaxstick.sweeps.tables import write_tables
from jaxstick.sweeps.values import values_of
from jaxstick.terminal import Terminal, stops_text
from jaxstick.version import version

lane_records = deferred("jaxstick.sweep", "lane_records")
draw_sweep = deferred("jaxstick.plots.sweep", "draw_sweep")

CONTACTS = ("loaded", "paper", "smooth")

MOST_CURVES = 6
"""Curves whose stop regions are listed on the terminal."""


class Values(click.ParamType):
    """Numbers and ranges between commas: 8,10.325 or 0.04:1.0:400; each is divided by `per` for SI units."""

    name = "values"

    def __init__(self, per: float = 1.0) -> None:
        self._per = per

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """The values in SI units."""
        if isinstance(value, tuple):
            return value
        try:
            return tuple(float(f"{number / self._per:.15g}") for number in values_of(str(value)))
        except ValueError as error:
            self.fail(f"{str(value)[:60]!r} {error}", param, ctx)


def _swept(*names: str, text: str, **options: Any) -> Any:
    return click.option(*names, type=Values(options.pop("per", 1.0)), metavar="VALUES", help=text, **options)


@click.command()
@click.argument("rig", metavar="RIG.toml", type=click.Path(path_type=Path))
@_swept("--ratios", required=True, text="Excitation over natural frequency, e.g. 0.04:1.0:400.")
@_swept(
    "--amplitudes-mm",
    "amplitudes",
    per=1e3,
    text="Amplitudes of the base [mm], e.g. 8,10.325; by default those of the runs in RIG.toml.",
)
@_swept("--A", "A", text="Static less dynamic friction [N].")
@_swept("--B", "B", text="Decay of the weakening with speed [s/m].")
@_swept("--C", "C", text="Dynamic friction [N].")
@_swept("--D", "D", text="Viscous slope [N s/m].")
@_swept("--k1", "k1", text="Stiffness of the contact in stick [N/m].")
@_swept("--friction-ratio", text="Dynamic over static friction C/(A + C), in place of A and C.")
@_swept("--friction-level", "level", text="Static friction A + C [N], in place of A and C.")
@click.option(
    "--contact", type=click.Choice(CONTACTS), default=CONTACTS[0], show_default=True, help="The contact."
)
@click.option(
    "--derivative",
    "derivatives",
    multiple=True,
    type=click.Choice(CONSTANTS),
    metavar="CONSTANT",
    help=f"Also the derivatives of the outcomes with respect to a constant: {', '.join(CONSTANTS)}.",
)
@click.option(
    "--chunk",
    type=click.IntRange(1, 1_000_000),
    default=CHUNK,
    show_default=True,
    metavar="N",
    help="Lanes computed at once; what a killed sweep has finished is kept chunk by chunk.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Let the workers of a Dask scheduler compute, e.g. tcp://10.0.0.5:8786.",
)
@click.option(
    "--out", required=True, metavar="DIR", type=click.Path(path_type=Path), help="Folder for the results."
)
@click.option("--overwrite", is_flag=True, help="Replace earlier results of jaxstick in DIR.")
@common
def sweep(
    rig: Path,
    contact: str,
    derivatives: tuple[str, ...],
    chunk: int,
    scheduler: str | None,
    out: Path,
    overwrite: bool,
    terminal: Terminal,
    **axes: tuple[float, ...] | None,
) -> int:
    """Find the periodic state of every combination of frequency, base amplitude and friction constants.

    VALUES are numbers and ranges between commas; low:high:count is a range with both its ends, with :log
    behind it in equal ratios. What is not swept is as RIG.toml says, friction under [assumed] and what else
    acts on the rig under [effects].

    DIR gets sweep.json, the same as sweep.csv, and plots. A sweep that was stopped or killed goes on where it
    was when the same command is given again. Nothing here is random.
    """
    sheet = load_rig(rig)
    plan = plan_sweep(sheet, axes, contact, tuple(sorted(set(derivatives))))
    done = 0
    try:
        with (
            OutputFolder(out, overwrite, inputs=[rig], resumable=True) as output,
            computing(scheduler) as evaluate,
        ):
            store = Store(output.kept, plan.fingerprint, plan.lanes, overwrite)
            done = store.finished
            if done:
                terminal.say(f"{done} of {plan.lanes} lanes are finished already.")

            def count(lanes: int) -> None:
                nonlocal done
                done += lanes
                bar.advance(f"{done} of {plan.lanes} lanes", lanes)

            with ProgressBar(terminal.progress_console(), remaining=True) as bar:
                bar.stage("sweeping", plan.lanes - done)
                finish(plan, store, evaluate, chunk, count)
                bar.stage("writing", 1)
                head = {
                    "schema": 1,
                    "version": version(),
                    "data": {"name": sheet.name, "sha256": sheet.sha256},
                    **plan.described(),
                }
                field, periods = _write(output, plan, store, head)
                draw_sweep(field, output)
    except (KeyboardInterrupt, click.Abort):
        return _stopped("stopped before it was done", done, plan, out)
    except ClusterLostError as lost:
        return _stopped(str(lost), done, plan, out)
    for notice in (*sheet.notices, *plan.notices):
        terminal.say(notice)
    _show(field, periods, plan, terminal)
    terminal.say(f"Results are in {out}.")
    if terminal.json:
        with (out / "sweep.json").open(encoding="utf-8") as stream:
            shutil.copyfileobj(stream, sys.stdout)
    return DONE


def _stopped(why: str, done: int, plan: Plan, out: Path) -> int:
    kept = f"{done} of {plan.lanes} lanes are kept, and the same command goes on from there"
    click.echo(f"jaxstick: {out}: {why}; {kept if done else 'no lane was finished'}.", err=True)
    return FAILED


def _write(
    output: OutputFolder, plan: Plan, store: Store, head: Mapping[str, Any]
) -> tuple[Field, dict[int, int]]:
    """Writes the tables; the outcomes over the axes, and how many lanes have which period (0: none)."""
    builder = FieldBuilder(plan)
    periods: dict[int, int] = {}

    def passing() -> Any:
        for chunk in store.chunks():
            builder.add(chunk)
            for period in chunk["period"].tolist():
                periods[int(period)] = periods.get(int(period), 0) + 1
            yield chunk

    with (
        atomic_writer(output.path("sweep.json")) as json_stream,
        atomic_writer(output.path("sweep.csv")) as csv_stream,
    ):
        write_tables(json_stream, csv_stream, head, passing(), lane_records)
    return builder.field(), periods


def _show(field: Field, periods: Mapping[int, int], plan: Plan, terminal: Terminal) -> None:
    counts = [
        f"{count} with period {period}" if period else f"{count} not periodic"
        for period, count in sorted(periods.items(), key=lambda item: item[0] or float("inf"))
    ]
    terminal.say(f"{plan.lanes} lanes: {', '.join(counts)}.")
    along = list(field.axes)[-1]
    found = list(curves(field, along))
    if len(field.axes[along]) < 2 or len(found) > MOST_CURVES:
        return
    factor = AXES[along].factor
    for chosen, curve in found:
        rows = [
            (
                "not periodic" if region.stops is None else stops_text(region.stops),
                f"{factor * region.low:.4g}",
                f"{factor * region.high:.4g}",
            )
            for region in regions(curve.axes[along], curve.outcomes["stops"])
        ]
        where = said(field, chosen)
        title = f"Stop regions over the {AXES[along].meaning}"
        terminal.table(f"{title}, {where}" if where else title, ("stops a cycle", "from", "to"), rows)
