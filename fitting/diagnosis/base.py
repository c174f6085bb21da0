"""The ground that every hypothesis is judged on: runs cut into lanes, the nominal model fitted to them."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.model import COLUMNS, Model
from fitting.diagnosis.refit import Bench, Point, job, refit
from fitting.diagnosis.release import settled
from fitting.diagnosis.wander import LEAST, OWN, START, with_room
from fitting.lanes import Lanes
from fitting.problem import Problem, beginnings
from fitting.progress import Progress
from fitting.segments import Segment, lay_out
from fitting.settings import Settings
from fitting.signals import Signals
from fitting.stage import steps
from jaxstick.formats.harmonic import fit_harmonic
from jaxstick.record import Run

UNITS = 4
"""Lanes are this many shortest segments long."""
REMNANT = 0.25
"""What is left of a run after its last whole segment and is shorter than this share of one goes with it."""
LEAD = 4
"""A lane begins one so-manieth of its length before its samples count."""
PERIODIC = 0.98
"""An excitation of which one sine has this share of the variance repeats itself."""
LENGTHS = (48, 96, 192, 384, 768)
"""Numbers of samples in a lane, the one nearest to a natural period is taken: few, so that programs serve
many data sets."""
BLUR = 0.06
FEW, MORE = 48, 192
"""The search begins on so many of the shortest segments, spread evenly; its best points go on on more."""
SEARCH, FINALISTS, REFINED = 25, 3, 15
HOPELESS = 2.0
STIFFER = (1.0, 20.0)
TOLERANCE, NEARLY_ALL = 0.1, 0.9
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


def cut_in_step(signals: Sequence[Signals], samples: int) -> tuple[list[Segment], list[int]]:
    """Segments of at most so many samples that cover every run, and a number for each that lanes of the same
    run share if they begin at the same phase of a periodic excitation, -1 for none.

    A cycle is cut into equal segments, or as many cycles as fit make one.
    """
    segments, phases, known = [], [], 0
    for number, signal in enumerate(signals):
        run, total = signal.run, len(signal.run.time)
        cycle = _cycle(run)
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


def _cycle(run: Run) -> float | None:
    """The number of samples in a cycle of a run's excitation; None where none is stated or seen."""
    if run.frequency is not None:
        return 1 / (run.frequency * run.interval)
    for channel in (run.base, run.force):
        if channel is not None and np.ptp(channel) > 0:
            found = fit_harmonic(run.time, channel)
            if found.amplitude**2 / 2 > PERIODIC * np.var(channel):
                return 1 / (found.frequency * run.interval)
    return None


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
    lanes = tempered(lay_out(problem.chosen, led, rig, force, substeps, beyond=beyond))
    before = np.array([[own.first - long.first] for own, long in zip(segments, led, strict=True)])
    counts = np.arange(samples + beyond) >= before
    lanes = dataclasses.replace(
        lanes,
        displacement_weight=np.asarray(lanes.displacement_weight) * counts,
        friction_weight=np.asarray(lanes.friction_weight) * counts,
    )
    runs = np.array([segment.run for segment in segments])
    wanders = any(signal.run.friction is not None for signal in problem.chosen)
    return Bench(with_room(lanes), runs, len(problem.chosen), np.array(phases), wanders)


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
    """The nominal model, sought from several points on the shortest segments, where a misfit has hardly any
    local minima, and fitted to segments of about one natural period."""
    samples = length(problem)
    segments, phases = cut_in_step(problem.chosen, samples)
    short = [part for segment in segments for part in divided(segment, UNITS)]
    begin = _beginnings(problem, settings)

    def fine(group: int, points: Sequence[np.ndarray]) -> int:
        stiffest = max(problem.unknowns.values(coordinates)["k1"] for coordinates in points)
        return steps(problem, group, stiffest, settings)

    some = lay(problem, short, [-1] * len(short), fine(1, list(begin)), samples // UNITS + 1, 0).coarser()
    few, more = (
        some.take(np.unique(np.linspace(0, len(short) - 1, lanes).round().astype(int)))
        for lanes in (FEW, MORE)
    )
    constants = model.index(*model.constants)
    points = [_at_rest(model, few, coordinates) for coordinates in begin]
    progress.stage("nominal model", SEARCH + REFINED)
    rough = refit(
        model,
        few,
        points,
        [constants] * len(points),
        iterations=SEARCH,
        wander=False,
        progress=lambda: progress.advance(),
    )
    rough = sorted(rough, key=lambda fit: fit.misfit)[:FINALISTS]
    points = [_at_rest(model, more, fit.point.coordinates[constants]) for fit in rough]
    found = refit(model, more, points, [constants] * len(points), wander=False)
    best = [fit.point.coordinates[constants] for fit in found]
    bench = lay(problem, segments, phases, fine(UNITS, best), samples, samples // LEAD)
    points = [_at_rest(model, bench, coordinates) for coordinates in best]
    points = [dataclasses.replace(point, own=settled(model, bench, point)[0]) for point in points]
    fits = refit(
        model,
        bench,
        points,
        [constants] * len(points),
        iterations=REFINED,
        wander=False,
        hopeless=HOPELESS,
        progress=lambda: progress.advance(),
    )
    fit = min(fits, key=lambda fit: fit.misfit)
    widths = np.full(OWN - START, WANDER if bench.wanders else LEAST)
    return Ground(tuple(segments), bench, dataclasses.replace(fit.point, widths=widths))


def _beginnings(problem: Problem, settings: Settings) -> np.ndarray:
    """Where the search begins: contacts that are read off are often far too soft, for a record shows how one
    gives way only while it sticks, so that stiffer ones are tried beside them."""
    points = beginnings(problem, settings)
    place = problem.unknowns.names.index("k1")
    values = problem.unknowns.members[place].to_value(points[:, place])
    out = []
    for factor in STIFFER:
        other = points.copy()
        other[:, place] = problem.unknowns.members[place].to_coordinate(factor * values)
        out.append(np.clip(other, problem.unknowns.lower, problem.unknowns.upper))
    return np.concatenate(out)


def _at_rest(model: Model, bench: Bench, constants: np.ndarray) -> Point:
    """The nominal model with these constants (coordinates), lanes starting as recorded, friction not
    wandering."""
    coordinates = model.origin({})
    coordinates[model.index(*model.constants)] = constants
    widths = np.full(OWN - START, LEAST)
    return Point((), coordinates, np.zeros(bench.runs), np.asarray(bench.lanes.start), widths)


def resolved(model: Model, bench: Bench, point: Point) -> Bench:
    """The bench with no more integration steps than residuals can tell: half or a quarter as many where, in
    nearly all lanes, that changes residuals by less than `TOLERANCE` standard deviations of the noise."""
    none = np.full((len(bench.lanes), COLUMNS), -1)
    finest, *others = (
        (one, model.columns([job(one, point, none)])[0].residual[:, :-OWN])
        for one in (bench, bench.coarser(), bench.coarser().coarser())
    )
    counted = np.maximum(bench.lanes.counted(), 1)
    found = finest[0]
    for one, residual in others:
        error = np.sqrt(((residual - finest[1]) ** 2).sum(1) / counted)
        if not np.quantile(error, NEARLY_ALL) < TOLERANCE:
            break
        found = one
    return found


def nuisances(model: Model) -> np.ndarray:
    """What is free under every hypothesis: the friction constants, the rig within its tolerance, the shape of
    the contact."""
    return model.index(*model.common)
