"""How fast: jaxstick against other ways to simulate many stick-slip oscillators, at equal error.

Lanes of the 1987 paper's rig over the drive's frequency, friction and contact stiffness run for eight natural
periods from rest. Every solver gets the loosest step or tolerance with which its displacement differs from
the event-driven reference by at most 1e-4 of the stroke (root mean square over lanes of the largest
difference); diffrax's Tsit5 solves the smooth contact, and its error is the one from that contact's own
solution. Times are minima of rounds in which all solvers take turns: the processor's time where one
core works, so that a busy machine does not count, the wall's clock where all of them do. Compilation does not
count. What a diagnosis spends its time on, lanes of real length linearised with two effects, with a group of
them or the whole shelf attached, is set against the same without any.

    python -m scripts.benchmark [--quick] [--json]
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import click
import jax
from rich.console import Console
from rich.table import Table

from jaxstick.compiled import cores
from jaxstick.precision import float64
from scripts.benchmark_parts.contest import Entry, Size, contest
from scripts.benchmark_parts.growth import Growth, accelerator, growth, memory
from scripts.benchmark_parts.linearisation import linearised

QUICK = Size(lanes=128, tsit5_lanes=32, checked=4, scipy_lanes=2, repeats=2)
FULL = Size(lanes=4096, tsit5_lanes=512, checked=16, scipy_lanes=8, repeats=7)
COUNTS = (1, 16, 256, 4096, 65536)
JACOBIANS_UP_TO = 4096
ACCELERATOR_LANES = 65536


def measured(quick: bool) -> dict[str, Any]:
    """All figures: times in seconds, ratios, memory in GB."""
    size = QUICK if quick else FULL
    cpu = jax.devices("cpu")[0]
    with float64(), jax.default_device(cpu), tempfile.TemporaryDirectory() as folder:
        entries, steps = contest(size, Path(folder))
        counts = COUNTS[:3] if quick else COUNTS
        grown = growth(counts, steps, size.repeats if quick else 5, JACOBIANS_UP_TO)
        taken = None if quick else memory(steps)
        alone, *attached = linearised(size.repeats, groups=1 if quick else None)
    with float64():
        other = accelerator(counts[-1] if quick else ACCELERATOR_LANES, steps, size.repeats)
    return {
        "cores": cores(),
        "solvers": [_of_entry(entry, entries[0]) for entry in entries],
        "growth": [_of_growth(row) for row in grown],
        "linearised": [
            {**each._asdict(), "nominal": each.seconds / alone.seconds} for each in (alone, *attached)
        ],
        "memory_gb_for_1e6_lanes": taken,
        "accelerator": None if other is None else {"name": other[0], "seconds_a_lane": other[1]},
    }


def _of_entry(entry: Entry, first: Entry) -> dict[str, Any]:
    """The entry, with how many times longer it takes than ours: both on one core, both on what they can use
    of the machine."""
    ours, theirs = first.all_cores or first.one_core, entry.all_cores or entry.one_core
    return {
        **entry._asdict(),
        "ratio_one_core": entry.one_core / first.one_core,
        "ratio_all_cores": theirs / ours,
    }


def _of_growth(row: Growth) -> dict[str, Any]:
    return {
        **row._asdict(),
        "jacobian_in_simulations": row.jacobian / row.one_core if row.jacobian else None,
    }


def tables(figures: dict[str, Any]) -> list[Table]:
    """The figures for a reader."""
    against = Table(title=f"time a lane at equal error, {figures['cores']} cores")
    for head in ("solver", "setting", "error / stroke", "one core", "all cores", "x ours", "x ours, all"):
        against.add_column(head, justify="left" if head in ("solver", "setting") else "right")
    for row in figures["solvers"]:
        against.add_row(
            row["solver"],
            row["setting"],
            f"{row['error']:.1e}",
            _time(row["one_core"]),
            _time(row["all_cores"]),
            f"{row['ratio_one_core']:.3g}",
            f"{row['ratio_all_cores']:.3g}",
        )
    own = Table(title="jaxstick over the number of lanes: time a lane")
    for head in ("lanes", "one core", "all cores", "gain of all cores", "Jacobian in simulations"):
        own.add_column(head, justify="right")
    for row in figures["growth"]:
        jacobian = row["jacobian_in_simulations"]
        own.add_row(
            str(row["lanes"]),
            _time(row["one_core"]),
            _time(row["all_cores"]),
            f"{row['gain_of_all_cores']:.2f}",
            "" if jacobian is None else f"{jacobian:.2f}",
        )
    effects = Table(title="a lane of a diagnosis linearised, one core")
    effects.add_column("effects attached")
    for head in ("time", "x nominal", "compiled in"):
        effects.add_column(head, justify="right")
    for row in figures["linearised"]:
        attached = ", ".join(row["effects"]) or "none"
        effects.add_row(attached, _time(row["seconds"]), f"{row['nominal']:.2f}", f"{row['compiled']:.1f} s")
    return [against, own, effects]


def _time(seconds: float | None) -> str:
    return "" if seconds is None else f"{1e6 * seconds:.3g} us"


@click.command()
@click.option("--quick", is_flag=True, help="Few lanes and rounds: whether it runs, not how fast.")
@click.option("--json", "as_json", is_flag=True, help="The figures as one JSON object instead of tables.")
def main(quick: bool, as_json: bool) -> None:
    """Times jaxstick against other solvers at equal error, all in one run."""
    figures = measured(quick)
    if as_json:
        click.echo(json.dumps(figures, indent=2))
        return
    console = Console()
    for table in tables(figures):
        console.print(table)
    if figures["memory_gb_for_1e6_lanes"] is not None:
        console.print(f"amplitudes of 1e6 lanes take {figures['memory_gb_for_1e6_lanes']:.2f} GB")
    if figures["accelerator"] is not None:
        other = figures["accelerator"]
        console.print(f"{other['name']}: {_time(other['seconds_a_lane'])} a lane")


if __name__ == "__main__":
    main()
