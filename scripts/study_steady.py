"""Periodic states found directly against periodic states marched to, on the rig of the 1987 paper.

A sweep of 400 frequency ratios from 0.04 to 1 is solved twice in one run: by `jaxstick.steady`, and by
running the same laps from rest until each closes to 1e-9 of its ranges (at most 200 of them), lanes that have
closed left out. Then, of every lane, whether both came to the same motion; and of some lanes, whether the
event-driven reference marched for 200 cycles did.

    python -m scripts.study_steady [--lanes 400] [--reference 12] [--contact loaded]
"""

from __future__ import annotations

import argparse
import time
from typing import NamedTuple

import numpy as np
from rich.console import Console
from scipy.interpolate import CubicSpline

from jaxstick.laps import Course, Laps, Real
from jaxstick.nominal import nominal
from jaxstick.parts.contact import LoadedContact, PaperContact, SmoothContact
from jaxstick.parts.drive import SineDrive
from jaxstick.pursuit import TOLERANCE
from jaxstick.record import AssumedConstants, KnownRig
from jaxstick.return_map import BLOCK
from jaxstick.steady import RESOLUTION, PeriodicStates, periodic_states
from jaxstick.steady_outcome import steady_outcomes
from tests.reference import loaded, rig1987

CONTACTS = {"loaded": LoadedContact, "paper": PaperContact, "smooth": SmoothContact}
RIG = KnownRig(rig1987.MASS, rig1987.STIFFNESS, rig1987.STIFFNESS, rig1987.DAMPING, 0.0)
MOST_LAPS = 200


class Marched(NamedTuple):
    """Laps run by every lane, the state after them, whether it closed."""

    laps: Real
    state: Real
    closed: np.ndarray


def of_1987(ratios: Real, contact: str) -> Laps:
    """The rig of 1987 at these frequency ratios."""
    rig = rig1987.rig()
    constants = AssumedConstants(rig.A, rig.B, rig.C, rig.D, rig.k1)
    lanes = []
    for ratio in ratios:
        drive = SineDrive(ratio * rig1987.NATURAL_FREQUENCY, rig1987.BASE_AMPLITUDE)
        oscillator = nominal(RIG, constants, drive)
        lanes.append(type(oscillator)(oscillator.rig, drive, oscillator.friction, CONTACTS[contact](rig.k1)))
    return Laps.of(lanes)


def march(laps: Laps, section: Real) -> Marched:
    """Every lane from rest, lap by lap, until it closes."""
    course = Course(np.arange(len(laps)), section, laps.steps(RESOLUTION), np.ones(len(laps)))
    state = laps.begin(course)
    count = np.zeros(len(laps))
    open_ = np.arange(len(laps))
    for _ in range(MOST_LAPS):
        way = laps.traverse(course.take(open_), state[open_])
        gap = np.max(np.abs(way.end - state[open_]) / (way.greatest - way.least + 1e-30), axis=1)
        state[open_] = way.end
        count[open_] += 1
        open_ = open_[gap >= TOLERANCE]
        if not len(open_):
            break
    closed = np.ones(len(laps), bool)
    closed[open_] = False
    return Marched(count, state, closed)


def reference_gap(laps: Laps, states: PeriodicStates, lane: int, ratio: float) -> float:
    """The largest difference in displacement from the reference in its 200th cycle, over the stroke."""
    drive = rig1987.drive(ratio)
    samples = 400
    cycle = np.arange(samples + 1) / samples
    start = MOST_LAPS - 1 + float(states.course.section[lane])
    run = loaded.simulate(rig1987.rig(), drive, drive.period * np.concatenate([[0.0], start + cycle]))
    course = states.course.take(np.array([lane]))
    seen: list[Real] = []
    laps.record(course, states.state[[lane]], lambda _, x: seen.append(x) or np.zeros(len(x)))
    ours = seen[0][0, : round(course.steps[0] / BLOCK)]
    places = np.arange(len(ours) + 1) / len(ours)
    again = CubicSpline(places, np.concatenate([ours[-1:], ours]), bc_type="periodic")(cycle)
    return float(np.abs(again - run.x[1:]).max() / np.ptp(run.x[1:]))


def main() -> None:
    """Prints what was measured."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--lanes", type=int, default=400)
    parser.add_argument("--reference", type=int, default=12)
    parser.add_argument("--contact", choices=list(CONTACTS), default="loaded")
    given = parser.parse_args()
    console = Console()
    ratios = np.linspace(0.04, 1.0, given.lanes)
    laps = of_1987(ratios, given.contact)
    states = periodic_states(laps)
    steady_outcomes(laps, states)
    march(laps, states.course.section)

    times: dict[str, list[float]] = {"found": [], "outcomes": [], "marched": []}
    for _ in range(3):
        begin = time.perf_counter()
        states = periodic_states(laps)
        times["found"].append(time.perf_counter() - begin)
        begin = time.perf_counter()
        outcomes = steady_outcomes(laps, states)
        times["outcomes"].append(time.perf_counter() - begin)
        begin = time.perf_counter()
        marched = march(laps, states.course.section)
        times["marched"].append(time.perf_counter() - begin)
    best = {name: min(values) for name, values in times.items()}
    steps = states.course.steps
    work = np.sum(states.laps * steps), np.sum(marched.laps * steps)
    console.print(f"{given.lanes} lanes, {steps.sum():.3g} steps a cycle of all of them")
    console.print({name: round(value, 2) for name, value in best.items()}, "seconds, the best of three")
    console.print(
        f"work in cycles of all lanes: {work[0] / steps.sum():.1f} found, {work[1] / steps.sum():.1f} marched"
    )
    gain = work[1] / work[0], best["marched"] / best["found"]
    console.print(f"found : marched = 1 : {gain[0]:.1f} in work, 1 : {gain[1]:.1f} in time")
    both = (states.period == 1) & marched.closed
    easy = np.sum(states.laps[both] * steps[both]), np.sum(marched.laps[both] * steps[both])
    console.print(f"the same where both closed after one cycle: 1 : {easy[1] / easy[0]:.1f} in work")
    for period in np.unique(states.period):
        lanes = np.flatnonzero(states.period == period)
        shown = np.round(ratios[lanes], 4).tolist() if len(lanes) < 30 else "most"
        console.print(f"period {period}: {len(lanes)} lanes, {shown}")
    console.print(f"largest residual of a periodic lane {states.residual[states.period > 0].max():.1e}")
    console.print("not closed by marching:", np.round(ratios[~marched.closed], 4).tolist())

    whole = laps.traverse(states.course, states.state)
    gap = np.abs(marched.state - states.state)[:, 0] / (whole.greatest - whole.least)[:, 0]
    other = both & (gap > 1e-6)
    console.print("came to another motion than marching:", np.round(ratios[other], 4).tolist())
    changes = np.flatnonzero(np.diff(outcomes.stops))
    console.print(
        "stops change at",
        [(round(float(ratios[i]), 3), outcomes.stops[i], outcomes.stops[i + 1]) for i in changes],
    )
    inner = outcomes.amplitude
    minima = np.flatnonzero((inner[1:-1] < inner[:-2]) & (inner[1:-1] < inner[2:])) + 1
    console.print("local minima of the amplitude at", np.round(ratios[minima], 3).tolist())
    if given.contact != "loaded":
        return
    chosen = np.flatnonzero(states.period == 1)
    for lane in chosen[np.linspace(0, len(chosen) - 1, given.reference).astype(int)]:
        found = reference_gap(laps, states, int(lane), float(ratios[lane]))
        console.print(
            f"ratio {ratios[lane]:.4f}: {found:.1e} of the stroke from the reference after 200 cycles"
        )


if __name__ == "__main__":
    main()
