"""The ground that every hypothesis is judged on: runs cut into lanes, the nominal model fitted to them."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import Bench, Point
from fitting.diagnosis.release import settled
from fitting.diagnosis.wander import OWN, START, with_room
from fitting.joining import chains
from fitting.lanes import Lanes
from fitting.problem import Problem, beginnings
from fitting.progress import Progress
from fitting.search import FINALISTS, descend_from, finish, refine
from fitting.segments import Segment, lay_out
from fitting.settings import Settings
from fitting.signals import Signals
from fitting.stage import stage, steps

UNITS = 4
"""Lanes are this many shortest segments long."""
LEAD = 4
"""A lane begins one so-manieth of its length before its samples count."""
LENGTHS = (48, 96, 192, 384, 768)
"""Numbers of samples in a lane, the one nearest to a natural period is taken: few, so that programs serve
many data sets."""
SUBSTEPS = (4, 8, 16, 32, 64)
"""Integration steps a sample: few choices as well."""
BLUR = 0.06
WANDER = 0.01
"""How far friction is first taken to wander, as a share of itself."""
NOISY_BEND = 8.0
"""Bends below so many standard deviations of noise are taken for noise: three of those of a bend of noise."""


@dataclasses.dataclass(frozen=True)
class Ground:
    """Lanes of all runs, and the nominal model at what the search for its constants found."""

    segments: tuple[Segment, ...]
    bench: Bench
    point: Point


def length(problem: Problem) -> int:
    """How many samples a lane has."""
    interval = max(signal.run.interval for signal in problem.chosen)
    return min(LENGTHS, key=lambda samples: abs(math.log(samples * interval / problem.period)))


def cut_evenly(signals: Sequence[Signals], samples: int) -> list[Segment]:
    """Segments of at most so many samples that cover every run."""
    segments = []
    for number, signal in enumerate(signals):
        total = len(signal.run.time)
        edges = np.linspace(0, total, math.ceil(total / samples) + 1).round().astype(int)
        segments += [Segment(number, int(a), int(b)) for a, b in itertools.pairwise(edges)]
    return segments


def joined_evenly(segments: Sequence[Segment], count: int) -> list[Segment]:
    """Every `count` consecutive segments of a run as one, the last of a run shorter."""
    out = []
    for number, group in itertools.groupby(segments, key=lambda segment: segment.run):
        parts = list(group)
        firsts = range(0, len(parts), count)
        out += [Segment(number, parts[i].first, parts[min(i + count, len(parts)) - 1].last) for i in firsts]
    return out


def lay(problem: Problem, segments: Sequence[Segment], substeps: int) -> Bench:
    """Segments as a bench: each lane begins a while before its segment, so that what has a memory remembers
    when the first sample counts, and all are filled up to the same number of samples."""
    lead = length(problem) // LEAD
    led = [dataclasses.replace(segment, first=max(segment.first - lead, 0)) for segment in segments]
    samples = max(segment.last - segment.first for segment in led)
    rig, force = problem.dataset.rig, problem.scale.force
    beyond = max(0, length(problem) + lead - samples)
    lanes = tempered(lay_out(problem.chosen, led, rig, force, substeps, beyond=beyond))
    before = np.array([[own.first - long.first] for own, long in zip(segments, led, strict=True)])
    counts = np.arange(samples + beyond) >= before
    lanes = dataclasses.replace(
        lanes,
        displacement_weight=np.asarray(lanes.displacement_weight) * counts,
        friction_weight=np.asarray(lanes.friction_weight) * counts,
    )
    return Bench(with_room(lanes), np.array([segment.run for segment in segments]), len(problem.chosen))


def tempered(lanes: Lanes) -> Lanes:
    """The lanes with corners weighed down: where a channel bends sharply from one sample to the next, the
    sensor's own filter and the instant of sampling decide what is read, by a share `BLUR` of the bend."""
    return dataclasses.replace(
        lanes,
        displacement_weight=_tempered(np.asarray(lanes.displacement), np.asarray(lanes.displacement_weight)),
        friction_weight=_tempered(np.asarray(lanes.friction), np.asarray(lanes.friction_weight)),
    )


def _tempered(samples: np.ndarray, weight: np.ndarray) -> np.ndarray:
    bend = np.zeros_like(samples)
    bend[:, 1:-1] = np.abs(np.diff(samples, 2, axis=1)) * weight[:, 1:-1]
    bend = np.maximum(bend - NOISY_BEND, 0.0)
    around = bend.copy()
    around[:, 1:] = np.maximum(around[:, 1:], bend[:, :-1])
    around[:, :-1] = np.maximum(around[:, :-1], bend[:, 1:])
    return weight / np.sqrt(1 + (BLUR * around) ** 2)


def ground(problem: Problem, model: Model, settings: Settings, progress: Progress) -> Ground:
    """The nominal model, sought from several points on the shortest segments and fitted to segments of about
    one natural period, with the rig's properties free within their tolerance."""
    short = cut_evenly(problem.chosen, length(problem) // UNITS)
    here = stage(problem, 1, short, problem.opening["k1"], settings)
    descent = descend_from(here, beginnings(problem, settings), settings, progress)
    points = descent.coordinates[np.argsort(descent.loss)[:FINALISTS]]
    rough = finish(here, points, progress)
    segments = joined_evenly(short, UNITS)
    first = [chain[0] for chain in chains(short, segments)]
    k1 = problem.unknowns.values(rough.coordinates)["k1"]
    longer = stage(problem, UNITS, segments, k1, settings)
    found = refine(longer, rough.coordinates, rough.starts[first], progress)
    constants = problem.unknowns.values(found.coordinates)
    wanted = steps(problem, UNITS, constants["k1"], settings)
    bench = lay(problem, segments, next((n for n in SUBSTEPS if n >= wanted), SUBSTEPS[-1]))
    widths = np.full(OWN - START, WANDER)
    own = np.asarray(bench.lanes.start)
    point = Point((), model.origin(constants), np.zeros(bench.runs), own, widths)
    own, _ = settled(model, bench, point)
    return Ground(tuple(segments), bench, dataclasses.replace(point, own=own))


def nuisances(model: Model) -> np.ndarray:
    """What is free under every hypothesis: the friction constants and the rig within its tolerance."""
    return model.index(*model.constants, *model.rig)
