"""Periodic states found directly against periodic states marched to, on the rig of the 1987 paper.

A sweep of 400 frequency ratios from 0.04 to 1 is solved twice in one run: by `jaxstick.steady`, and by
running the same laps from rest until each closes to 1e-9 of its ranges (at most 200 of them). Both use the
same compiled laps with the same fine steps in the same packs, and lanes that have closed are left out;
marching does nothing but traverse and compare. Then the same once more for those lanes alone that marching
closes, which leaves out what it spends on the others; and of every lane, whether both came to the same
motion. Programs are compiled as under the command, beforehand; times are the least of several rounds.

    python -m scripts.study_steady [--lanes 400] [--contact loaded]
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from rich.console import Console

from jaxstick.compilation_cache import set_up_jax
from jaxstick.laps import Course, Laps, Real
from jaxstick.nominal import nominal
from jaxstick.parts.contact import LoadedContact, PaperContact, SmoothContact
from jaxstick.parts.drive import SineDrive
from jaxstick.pursuit import TOLERANCE
from jaxstick.record import AssumedConstants, KnownRig
from jaxstick.steady import RESOLUTION, periodic_states
from jaxstick.steady_outcome import steady_outcomes
from tests.reference import rig1987

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


def timed(rounds: int, *tasks: Callable[[], object]) -> list[tuple[float, float]]:
    """The least processor's and wall's times of each of these tasks [s], which take turns."""
    best = [(math.inf, math.inf)] * len(tasks)
    for _ in range(rounds):
        for number, task in enumerate(tasks):
            begin = time.process_time(), time.perf_counter()
            task()
            taken = time.process_time() - begin[0], time.perf_counter() - begin[1]
            best[number] = min(best[number][0], taken[0]), min(best[number][1], taken[1])
    return best


def compared(console: Console, title: str, found: tuple[float, float], marched: tuple[float, float]) -> None:
    """Prints the times of both and how they compare."""
    for clock, ours, theirs in zip(("processor", "wall"), found, marched, strict=True):
        console.print(f"{title}: {clock} {ours:.2f} s found, {theirs:.2f} s marched, 1 : {theirs / ours:.1f}")


def main() -> None:
    """Prints what was measured."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--lanes", type=int, default=400)
    parser.add_argument("--contact", choices=list(CONTACTS), default="loaded")
    given = parser.parse_args()
    set_up_jax()
    console = Console()
    ratios = np.linspace(0.04, 1.0, given.lanes)
    laps = of_1987(ratios, given.contact)
    states = periodic_states(laps)
    outcomes = steady_outcomes(laps, states)
    section = states.course.section
    marched = march(laps, section)

    found, summed, walked = timed(
        5,
        lambda: periodic_states(laps),
        lambda: steady_outcomes(laps, states),
        lambda: march(laps, section),
    )
    steps = states.course.steps
    work = np.sum(states.laps * steps), np.sum(marched.laps * steps)
    console.print(f"{given.lanes} lanes, {steps.sum():.3g} steps a cycle of all of them")
    compared(console, "all lanes", found, walked)
    console.print(f"amplitudes, stops, harmonics of all lanes: processor {summed[0]:.2f} s")
    console.print(
        f"work in cycles of all lanes: {work[0] / steps.sum():.1f} found, {work[1] / steps.sum():.1f} marched"
    )
    console.print(f"found : marched = 1 : {work[1] / work[0]:.1f} in work")
    both = (states.period == 1) & marched.closed
    easy = np.sum(states.laps[both] * steps[both]), np.sum(marched.laps[both] * steps[both])
    console.print(f"the same where both closed after one cycle: 1 : {easy[1] / easy[0]:.1f} in work")
    closing = of_1987(ratios[marched.closed], given.contact)
    some = timed(5, lambda: periodic_states(closing), lambda: march(closing, section[marched.closed]))
    compared(console, f"the {len(closing)} lanes that marching closes", *some)
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


if __name__ == "__main__":
    main()
