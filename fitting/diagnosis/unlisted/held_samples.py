"""Channels that stand still while the motion goes on, and then catch up in one step.

A converter, a bus or a buffer that has nothing new repeats its last value; what comes next is as far from it
as the motion has gone meanwhile. No force or displacement does so by itself: after standing still it sets out
no faster than the model does, be it early or late. Where a channel hardly changes anyway, nothing shows.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Prediction
from fitting.diagnosis.lanes.steadiness import robust_deviation
from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly
from jaxstick.check import quantity

STILL = 4.0
"""A channel stands still while its steps from sample to sample are less than so many times its noise,"""
FEWEST_STEPS = 2
"""so many of them or more."""
CATCHES_UP = 12.0
"""It catches up by a step of more than so many times its noise,"""
LEFT = 3.0
"""than so many robust standard deviations of what the nominal model leaves of it,"""
RESOLUTION = 4.0
"""and than so many times the least by which it is ever seen to change;"""
STEEPER = 2.0
"""which is more than so many times any step that the model makes meanwhile,"""
AS_FAR = 0.4
"""and what the model has moved by since, but for less than this share."""
FEWEST = 2
"""It is to do so in so many segments. In 60 sealed cases without any effect it did in none, in 13 of 15 in
which the force was held in two to 60."""


@dataclasses.dataclass(frozen=True)
class HeldSamples(AbstractAnomaly):
    """How often a channel (`channel`: as sentences name it) stood still and caught up, in how many runs, of
    how many, and by how much at the most, in its `unit`."""

    channel: str
    unit: str
    count: int
    runs: int
    of: int
    most: float

    @property
    def clause(self) -> str:
        return (
            f"the {self.channel} stands still for moments while the motion goes on, and catches up in one "
            f"step of up to {quantity(self.most, self.unit)}, as a converter makes it that repeats its last "
            "value"
        )

    @property
    def note(self) -> str:
        return (
            f"In {self.runs} of {self.of} runs the {self.channel} stood still and then caught up with the "
            f"motion in one step, {self.count} times in all, by up to {quantity(self.most, self.unit)}: look "
            "for values that a converter, a bus or a buffer repeats where it has no new one."
        )

    @property
    def look(self) -> str:
        return (
            "Feed a signal that never rests, as a sine of a generator, into the channel of the "
            f"{self.channel}, and write a counter beside every sample: values that repeat there are held on "
            "the way to the file."
        )

    @property
    def side(self) -> str:
        return "measurement"


def held_samples(bench: Bench, seen: Prediction) -> HeldSamples | None:
    """What there is of them in the friction force, or else in the displacement; None where there are few.
    `seen`: what the bench shows under the nominal model."""
    lanes = bench.lanes
    weights = lanes.weights()
    for channel, unit, record, expected, weight in (
        ("friction force", "N", np.asarray(lanes.friction), seen.friction, weights[:, :, 1]),
        ("displacement", "m", np.asarray(lanes.displacement), seen.displacement, weights[:, :, 0]),
    ):
        counts = weight > 0
        if not counts.any():
            continue
        noise = 1 / float(np.median(weight[counts]))
        least = max(
            CATCHES_UP * noise,
            LEFT * robust_deviation((record - expected)[counts]),
            RESOLUTION * _resolution(record, counts, bench.run),
        )
        sizes = [
            list(_caught_up(*lane, STILL * noise, least))
            for lane in zip(record, expected, counts, strict=True)
        ]
        held = np.array([len(each) for each in sizes])
        if np.count_nonzero(held) >= FEWEST:
            runs, of = len(np.unique(bench.run[held > 0])), len(np.unique(bench.run))
            most = max(size for each in sizes for size in each)
            return HeldSamples(channel, unit, int(held.sum()), runs, of, most)
    return None


def _resolution(record: np.ndarray, counts: np.ndarray, run: np.ndarray) -> float:
    """The least by which the values of a record (lanes, samples) differ in the coarsest of its runs."""
    values = (np.unique(record[run == each][counts[run == each]]) for each in np.unique(run))
    return max((float(np.diff(each).min()) for each in values if len(each) > 1), default=np.inf)


def _caught_up(
    record: np.ndarray, expected: np.ndarray, counts: np.ndarray, still: float, least: float
) -> Iterator[float]:
    """The sizes of the steps by which the record of a lane (samples) catches up with what is expected.

    counts: which samples do; still, least: smaller steps are none, and larger ones may catch up.
    """
    steps, moves = np.diff(record), np.diff(expected)
    for place in np.flatnonzero(np.abs(steps) > least).tolist():
        size, begin = abs(float(steps[place])), place
        while begin > 0 and abs(steps[begin - 1]) < still:
            begin -= 1
        if place - begin < FEWEST_STEPS or not counts[begin : place + 2].all():
            continue
        moved = expected[place + 1] - expected[begin : place + 1]
        sudden = size > STEEPER * np.abs(moves[begin : place + 2]).max()
        if sudden and np.abs(moved - steps[place]).min() < AS_FAR * size:
            yield size
