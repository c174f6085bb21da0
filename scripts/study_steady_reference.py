"""Every periodic state of a sweep against the event-driven reference marched from rest, on the rig of 1987.

The reference is marched for 200 cycles at every frequency ratio, one file a lane in FOLDER; what is there
already is not computed again. Where it does not come to the motion that `jaxstick.steady` finds, it is
started at that motion, and `jaxstick.simulate` at the reference's, to see who stays. Then the stops and stick
fractions of the motions that agree are compared. About 8 minutes of one core the first time.

    python -m scripts.study_steady_reference FOLDER [--lanes 400] [--processes 1]
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.interpolate import CubicSpline

from jaxstick.laps import Laps, Real
from jaxstick.oscillator import Start
from jaxstick.outcome import outcome
from jaxstick.recurrence import LONGEST_PERIOD
from jaxstick.return_map import BLOCK
from jaxstick.simulate import simulate
from jaxstick.steady import PeriodicStates, periodic_states
from jaxstick.steady_outcome import SteadyOutcomes, steady_outcomes
from scripts.study_steady import of_1987
from tests.jaxstick.twin import twin
from tests.reference import loaded, rig1987

CYCLES, KEPT, SAMPLES = 200, 16, 400
"""Cycles of the reference, how many of the last are kept, samples in each of these."""

SAME = 1e-3
"""Motions that differ by less than this share of the stroke are the same."""

CLOSED = 1e-6
"""The reference's motion recurs where it comes back to this share of the stroke."""

STAYING = 60
"""Cycles for which one is marched from the motion of the other."""

FINE = 2000
"""Samples of the cycle in which stops are counted."""


@dataclass(frozen=True, eq=False)
class Reference:
    """The last cycles of the reference: displacement x [m], shape (KEPT, SAMPLES), from phase zero of the
    drive on; displacement, velocity and deflection of the contact at their end."""

    ratio: float
    x: Real
    end: tuple[float, float, float]

    @property
    def stroke(self) -> float:
        """Peak to peak [m]."""
        return float(np.ptp(self.x))

    def recurs(self, cycles: int) -> float:
        """How far the last cycle is from that so many before, in strokes."""
        return float(np.abs(self.x[-1] - self.x[-1 - cycles]).max()) / self.stroke

    def period(self) -> int:
        """Cycles after which it recurs, 0 where it does not."""
        return next((n for n in range(1, LONGEST_PERIOD + 1) if self.recurs(n) < CLOSED), 0)


def march(folder: Path, lane: int, ratio: float) -> None:
    """Writes the reference's file of this lane."""
    drive = rig1987.drive(ratio)
    cycles = np.concatenate([[0.0], CYCLES - KEPT + np.arange(KEPT * SAMPLES + 1) / SAMPLES])
    run = loaded.simulate(rig1987.rig(), drive, drive.period * cycles)
    unfinished = folder / f"{lane:04d}.part"
    with unfinished.open("wb") as file:
        end = np.array([run.x[-1], run.v[-1], run.z[-1]])
        np.savez(file, ratio=ratio, x=run.x[1:-1].reshape(KEPT, SAMPLES), end=end)
    unfinished.rename(_file(folder, lane))


def _file(folder: Path, lane: int) -> Path:
    return folder / f"{lane:04d}.npz"


def references(folder: Path, ratios: Real, processes: int) -> list[Reference]:
    """The references of these lanes, those without a file marched first."""
    folder.mkdir(parents=True, exist_ok=True)
    missing = [lane for lane in range(len(ratios)) if not _file(folder, lane).exists()]
    with ProcessPoolExecutor(processes) as pool:
        tasks = [pool.submit(march, folder, lane, float(ratios[lane])) for lane in missing]
        for task in track(tasks, "references"):
            task.result()
    found = []
    for lane, ratio in enumerate(ratios):
        with np.load(_file(folder, lane)) as kept:
            if float(kept["ratio"]) != ratio:
                raise ValueError(f"{_file(folder, lane)} is of another sweep")
            x, v, z = kept["end"].tolist()
            found.append(Reference(float(ratio), kept["x"], (x, v, z)))
    return found


def motions(laps: Laps, states: PeriodicStates) -> list[Real]:
    """Displacement of every lane over its period from phase zero of the drive on, (cycles, SAMPLES) [m]."""
    found: dict[int, Real] = {}

    def sampled(course: object, displacement: Real) -> Real:
        del course
        found[len(found)] = displacement
        return np.zeros(len(displacement))

    out = []
    for lane in range(len(laps)):
        course = states.course.take(np.array([lane]))
        found.clear()
        laps.record(course, states.state[[lane]], sampled)
        cycles = round(float(course.cycles[0]))
        x = found[0][0, : round(course.steps[0] * cycles / BLOCK)]
        places = np.arange(len(x) + 1) * (cycles / len(x))
        spline = CubicSpline(places, np.concatenate([x[-1:], x]), bc_type="periodic")
        wanted = np.arange(cycles * SAMPLES) / SAMPLES - float(course.section[0])
        out.append(spline(np.mod(wanted, cycles)).reshape(cycles, SAMPLES))
    return out


def apart(ours: Real, theirs: Real) -> float:
    """The largest difference in displacement over the cycles of ours, in strokes, shifted by the whole cycles
    that suit best."""
    last = theirs[-len(ours) :]
    gaps = [np.abs(np.roll(ours, shift, axis=0) - last).max() for shift in range(len(ours))]
    return float(min(gaps) / np.ptp(theirs))


def reference_stays(states: PeriodicStates, lane: int, ratio: float, ours: Real) -> float:
    """How far from our motion the reference is, `STAYING` cycles after it was started there, in strokes."""
    drive = rig1987.drive(ratio)
    x, v, z = states.state[lane, :3].tolist()
    section = float(states.course.section[lane])
    cycles = np.concatenate([[section], 1 + STAYING + np.arange(len(ours) * SAMPLES) / SAMPLES])
    run = loaded.simulate(rig1987.rig(), drive, drive.period * cycles, x, v, z)
    return apart(ours, run.x[1:].reshape(ours.shape))


def we_stay(reference: Reference) -> float:
    """How far from the reference's motion our simulation is, `STAYING` cycles after it was started there."""
    rig, drive = rig1987.rig(), rig1987.drive(reference.ratio)
    x, v, z = reference.end
    interval = drive.period / SAMPLES
    run = simulate(
        twin(rig, drive),
        samples=(STAYING + 1) * SAMPLES,
        interval=interval,
        start=Start(x, v, -rig.k1 * z),
    )
    cycles = max(1, reference.period())
    return apart(reference.x[-cycles:], np.asarray(run.x)[-LONGEST_PERIOD * SAMPLES :].reshape(-1, SAMPLES))


def verdict(states: PeriodicStates, lane: int, ours: Real, reference: Reference) -> str:
    """The class of a lane."""
    found, theirs = int(states.period[lane]), reference.period()
    if not found and not theirs:
        return "neither is periodic"
    if found and apart(ours, reference.x) < SAME:
        return "same motion" if found == theirs else "same motion, the reference not yet settled"
    if not found:
        return "only the reference is periodic"
    stays = reference_stays(states, lane, reference.ratio, ours) < SAME
    if not theirs:
        return "only ours is periodic" + (" and the reference stays there" if stays else "")
    also = we_stay(reference) < SAME
    return {
        (True, True): "another motion, both stay at both: they coexist",
        (True, False): "another motion, the reference stays at ours, we not at its",
        (False, True): "another motion, we stay at the reference's, it not at ours",
        (False, False): "another motion, neither stays at the other's",
    }[stays, also]


def counted(reference: Reference) -> tuple[float, float]:
    """Stops a cycle and stick fraction of the reference's next cycle, sampled finely."""
    drive = rig1987.drive(reference.ratio)
    x, v, z = reference.end
    times = drive.period * np.arange(FINE + 1) / FINE
    run = loaded.simulate(rig1987.rig(), drive, times, x, v, z)
    found = outcome(
        run.x[:-1],
        interval=float(times[1]),
        frequency=drive.frequency,
        natural_frequency=rig1987.NATURAL_FREQUENCY,
    )
    return found.stops, found.stick_fraction


def stops_and_sticks(
    console: Console, outcomes: SteadyOutcomes, same: list[int], all_: list[Reference]
) -> None:
    """Prints how stops and stick fractions of the lanes with the same motion compare."""
    counts = np.array([counted(all_[lane]) for lane in track(same, "stops")])
    other = outcomes.stops[same] != counts[:, 0]
    console.print(
        f"stops differ in {other.sum()} of {len(same)} lanes:",
        [
            (round(all_[lane].ratio, 4), float(outcomes.stops[lane]), float(stops))
            for lane, stops in zip(np.array(same)[other], counts[other, 0], strict=True)
        ],
    )
    gap = np.abs(outcomes.stick_fraction[same] - counts[:, 1])
    worst = int(np.argmax(gap))
    console.print(
        f"stick fractions differ by {np.median(gap):.1e} in the median, at most by {gap[worst]:.1e}, "
        f"at ratio {all_[same[worst]].ratio:.4f}; where the stops are as many, by {gap[~other].max():.1e}"
    )


def main() -> None:
    """Prints what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--lanes", type=int, default=400)
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    console = Console()
    ratios = np.linspace(0.04, 1.0, given.lanes)
    all_ = references(given.folder, ratios, given.processes)
    laps = of_1987(ratios, "loaded")
    states = periodic_states(laps)
    ours = motions(laps, states)
    verdicts = [verdict(states, lane, ours[lane], all_[lane]) for lane in range(len(laps))]
    table = Table("class", "lanes", "ratios")
    for name in sorted(set(verdicts), key=verdicts.count, reverse=True):
        lanes = [lane for lane, found in enumerate(verdicts) if found == name]
        shown = ", ".join(f"{ratios[lane]:.4f}" for lane in lanes) if len(lanes) < 30 else "the rest"
        table.add_row(name, str(len(lanes)), shown)
    console.print(table)
    for period in np.unique(states.period):
        theirs = [reference.period() for reference in all_]
        console.print(
            f"period {period}: {np.sum(states.period == period)} ours, {theirs.count(period)} theirs"
        )
    same = [lane for lane, found in enumerate(verdicts) if found.startswith("same")]
    gaps = np.array([apart(ours[lane], all_[lane].x) for lane in same])
    middle, high, most = np.quantile(gaps, [0.5, 0.9, 1.0])
    console.print(
        f"the same motions differ by {middle:.1e} of the stroke in the median, in nine of ten by less than "
        f"{high:.1e}, at most by {most:.1e}, at ratio {ratios[same[int(np.argmax(gaps))]]:.4f}"
    )
    strokes = [
        abs(np.ptp(mine) / reference.stroke - 1)
        for mine, reference, found in zip(ours, all_, verdicts, strict=True)
        if found == "neither is periodic"
    ]
    if strokes:
        console.print(
            f"strokes over some cycles differ by at most {max(strokes):.1e} where neither is periodic"
        )
    stops_and_sticks(console, steady_outcomes(laps, states), same, all_)


if __name__ == "__main__":
    main()
