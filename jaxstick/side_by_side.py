"""Simulates several oscillators at once, each as a lane of one compiled program."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from jaxstick.compiled import compiled, in_packs
from jaxstick.errors import UserError
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parts.drive import SineDrive
from jaxstick.precision import float64
from jaxstick.simulate import Grid, Trajectory, march, shortest_period, substeps

RESOLUTION = 200.0
MOST_STEPS = 4e9


class Journey(NamedTuple):
    """One simulation to do: the oscillator and its start, the first time [s], the interval [s], how many
    samples."""

    oscillator: Oscillator
    start: Start
    start_time: float
    interval: float
    samples: int


@float64
def side_by_side(journeys: Sequence[Journey], resolution: float = RESOLUTION) -> list[Trajectory]:
    """The trajectories of all journeys as numpy arrays, in their order.

    Journeys whose oscillators are built alike run as lanes of one program, as long as the longest of them,
    with integration steps small enough for the stiffest: `resolution` of them on the contact's ring, and half
    as many on a period of a sine drive.

    Raises UserError where that takes more than 4e9 steps.
    """
    groups: dict[Any, list[int]] = {}
    for number, journey in enumerate(journeys):
        groups.setdefault(jax.tree.structure(journey.oscillator), []).append(number)
    found: dict[int, Trajectory] = {}
    for numbers in groups.values():
        together = [journeys[number] for number in numbers]
        steps = max(_substeps(journey, resolution) for journey in together)
        samples = max(journey.samples for journey in together)
        if float(steps) * samples * len(together) > MOST_STEPS:
            raise UserError(
                f"{samples} samples with {steps} integration steps each are too many to simulate; shorten "
                "the runs, or look at k1, mass and drive, which ask for steps this small."
            )
        lanes = _stacked([journey.oscillator for journey in together])
        starts = _stacked([journey.start for journey in together])
        times = np.array([journey.start_time for journey in together], float)
        intervals = np.array([journey.interval for journey in together], float)
        out = in_packs(_march_lanes, (lanes, starts, times, intervals), samples, steps)
        for lane, number in enumerate(numbers):
            found[number] = Trajectory(*(channel[lane, : journeys[number].samples] for channel in out))
    return [found[number] for number in range(len(journeys))]


@compiled
def _march_lanes(
    lanes: tuple[Oscillator, Start, np.ndarray, np.ndarray], samples: int, steps: int
) -> Trajectory:
    def one(oscillator: Oscillator, start: Start, time: Any, interval: Any) -> Trajectory:
        return march(oscillator, start, Grid(time, interval, samples, steps), unroll=2)

    return jax.vmap(one)(*lanes)


def _substeps(journey: Journey, resolution: float) -> int:
    steps = substeps(journey.interval, shortest_period(journey.oscillator), resolution)
    drive = journey.oscillator.drive
    if isinstance(drive, SineDrive):
        steps = max(steps, math.ceil(journey.interval * float(drive.frequency) * resolution / 2))
    return steps


def _stacked(trees: Sequence[Any]) -> Any:
    """Trees of one structure as one, leaf by leaf with a leading axis of lanes; shorter leaves are filled up
    with zeros at their first axis."""

    def stack(*leaves: Any) -> np.ndarray:
        arrays = [np.asarray(leaf, float) for leaf in leaves]
        if arrays[0].ndim == 0:
            return np.stack(arrays)
        longest = max(len(array) for array in arrays)
        widths = [[(0, longest - len(array))] + [(0, 0)] * (array.ndim - 1) for array in arrays]
        return np.stack([np.pad(array, width) for array, width in zip(arrays, widths, strict=True)])

    return jax.tree.map(stack, *trees)
