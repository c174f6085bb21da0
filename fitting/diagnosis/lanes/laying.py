"""Runs cut into segments in step with their excitation, and segments laid out as lanes."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

import numpy as np
from scipy.ndimage import median_filter

from fitting.cycle import samples_a_cycle
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.wander import with_room
from fitting.lanes import Lanes
from fitting.problem import Problem
from fitting.segments import Segment, lay_out
from fitting.signals import Signals

REMNANT = 0.25
"""What is left of a run after its last whole segment and is shorter than this share of one goes with it."""
LEAD = 4
"""A lane begins one so-manieth of its length before its samples count."""
LENGTHS = (48, 96, 192, 384, 768)
"""Numbers of samples in a lane, the one nearest to a natural period is taken."""
MISREAD = 0.2
"""A lane's start may lie so far from the record, as a share of how far displacement and velocity of its run
go: a sensor that reads wrong or late, or smooths, shows another start than there was."""
BLUR = 0.06
NOISY_BEND = 8.0
"""Bends below so many standard deviations of noise are taken for noise: three of those of a bend of noise."""


def length(problem: Problem) -> int:
    """How many samples a lane has."""
    interval = max(signal.run.interval for signal in problem.chosen)
    return min(LENGTHS, key=lambda samples: abs(math.log(samples * interval / problem.period)))


def cut_in_step(signals: Sequence[Signals], samples: int) -> tuple[list[Segment], list[int]]:
    """Segments of at most so many samples that cover every run, and a number for each that lanes of the same
    run share if they begin at the same phase of a periodic excitation, -1 for none.

    A cycle is cut into equal segments, or as many cycles as fit make one.
    """
    segments, phases, known = [], [], 0
    for number, signal in enumerate(signals):
        run, total = signal.run, len(signal.run.time)
        cycle = samples_a_cycle(run)
        if cycle is None:
            count, length = 0, total / math.ceil(total / samples)
        else:
            count = max(1, math.ceil(cycle / samples))
            length = cycle / count if cycle > samples else cycle * math.floor(samples / cycle)
        edges = [*np.arange(0, total - REMNANT * length, length).round().astype(int).tolist(), total]
        for index, (first, last) in enumerate(itertools.pairwise(edges)):
            parts = math.ceil((last - first) / samples)
            segments += divided(Segment(number, first, last), parts)
            whole = count > 0 and parts == 1 and last - first > length - 1
            phases += [known + index % count if whole else -1] * parts
        known += count
    return segments, phases


def divided(segment: Segment, parts: int) -> list[Segment]:
    """A segment in so many parts of about the same length."""
    edges = np.linspace(segment.first, segment.last, parts + 1).round().astype(int)
    return [Segment(segment.run, int(a), int(b)) for a, b in itertools.pairwise(edges)]


def lay(
    problem: Problem,
    segments: Sequence[Segment],
    phases: Sequence[int],
    substeps: int,
    longest: int,
    lead: int,
) -> Bench:
    """Segments of at most `longest` samples as a bench: each lane begins `lead` samples before its segment,
    so that what has a memory remembers when the first sample counts, and all have the same number of samples.

    Friction may wander only where it was recorded: from the motion alone, a level and a slope for every lane
    are as good as any effect.
    """
    led = [dataclasses.replace(segment, first=max(segment.first - lead, 0)) for segment in segments]
    samples = max(segment.last - segment.first for segment in led)
    rig, force = problem.dataset.rig, problem.scale.force
    beyond = max(0, longest + lead - samples)
    plain = lay_out(problem.chosen, led, rig, force, substeps, beyond=beyond)
    lanes = tempered(plain)
    before = np.array([[own.first - long.first] for own, long in zip(segments, led, strict=True)])
    counts = np.arange(samples + beyond) >= before
    runs = np.array([segment.run for segment in segments])
    lanes = dataclasses.replace(
        lanes,
        displacement_weight=np.asarray(lanes.displacement_weight) * counts,
        friction_weight=np.asarray(lanes.friction_weight) * counts,
        start_deviation=np.hypot(lanes.start_deviation, _misread(problem.chosen)[runs]),
    )
    share, wanders = _share(lanes, plain), problem.friction_recorded
    return Bench(with_room(lanes), runs, len(problem.chosen), share, np.array(phases), wanders)


def lay_whole(problem: Problem, substeps: int) -> Bench:
    """All runs as lanes of about a natural period, in step with their excitation."""
    samples = length(problem)
    return lay(problem, *cut_in_step(problem.chosen, samples), substeps, samples, samples // LEAD)


def _share(lanes: Lanes, plain: Lanes) -> np.ndarray:
    """What noise alone leaves of squared residuals (lanes, samples, 2), whose weights have been lowered from
    those of plain lanes."""
    whole = plain.weights()
    return (lanes.weights() / np.where(whole > 0, whole, 1.0)) ** 2


def _misread(signals: Sequence[Signals]) -> np.ndarray:
    """How far displacement, velocity and friction of a run may be from the record for the sensors' sake."""
    return np.array(
        [
            [MISREAD * np.std(signal.run.displacement), MISREAD * np.std(signal.velocity), 0.0]
            for signal in signals
        ]
    )


def tempered(lanes: Lanes) -> Lanes:
    """The lanes with corners weighed down: where a channel bends sharply from one sample to the next, the
    sensor's own filter and the instant of sampling decide what is read, by a share `BLUR` of the bend. A
    single sample that stands out is no corner."""
    return dataclasses.replace(
        lanes,
        displacement_weight=_tempered(np.asarray(lanes.displacement), np.asarray(lanes.displacement_weight)),
        friction_weight=_tempered(np.asarray(lanes.friction), np.asarray(lanes.friction_weight)),
    )


def _tempered(samples: np.ndarray, weight: np.ndarray) -> np.ndarray:
    bend = np.zeros_like(samples)
    smooth = median_filter(samples, size=(1, 3), mode="nearest")
    bend[:, 1:-1] = np.abs(np.diff(smooth, 2, axis=1)) * weight[:, 1:-1]
    bend = np.maximum(bend - NOISY_BEND, 0.0)
    around = bend.copy()
    around[:, 1:] = np.maximum(around[:, 1:], bend[:, :-1])
    around[:, :-1] = np.maximum(around[:, :-1], bend[:, 1:])
    return weight / np.sqrt(1 + (BLUR * around) ** 2)
