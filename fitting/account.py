"""What a fitted model leaves of every run: piecewise with free starts, and in one free run."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from fitting.lanes import Lanes
from fitting.newton import OUTLIER, Solution, settle, unstick
from fitting.problem import Problem
from fitting.progress import Progress
from fitting.result import FreeRun, Gap, Trace
from fitting.segments import Segment, cut, lay_out, merged
from fitting.signals import Signals
from fitting.stage import Stage, unit


@dataclasses.dataclass(frozen=True)
class Account:
    """The gaps by run and channel, the errors of the free runs, and the traces they were taken from."""

    gaps: tuple[Gap, ...]
    free_runs: tuple[FreeRun, ...]
    traces: tuple[Trace, ...]


def account_for(problem: Problem, last: Stage, solution: Solution, progress: Progress) -> Account:
    """The account of every run, held out or not, at a solution.

    Runs that were fitted keep the segments and starts of the last stage; those held out are cut likewise and
    get the starts that suit them best. The free run of a record begins as its first segment does and never
    looks at the record again.
    """
    progress.stage("free runs", 2)
    coordinates, misfit = solution.coordinates, last.misfit
    pool = ThreadPoolExecutor(2)
    pieces = pool.submit(misfit.predict, last.lanes, _each(coordinates, last.lanes), solution.starts)
    starts = [solution.starts[_first(last.segments, number)] for number in range(len(problem.chosen))]
    held = tuple(signal for signal in problem.signals if signal.run.hold_out)
    segments, poor, fitted_held = [], np.zeros(0, bool), []
    if held:
        segments, lanes, best, poor = _held_out(problem, held, last, coordinates)
        fitted_held = joined(segments, *misfit.predict(lanes, _each(coordinates, lanes), best))
        starts += [best[_first(segments, number)] for number in range(len(held))]
    cuts = [*_cuts(last.segments, solution.weights < 0.5), *_cuts(segments, poor)]
    signals = (*problem.chosen, *held)
    whole = [Segment(number, 0, len(signal.run.time)) for number, signal in enumerate(signals)]
    records = lay_out(signals, whole, problem.dataset.rig, problem.scale.force, last.lanes.substeps)
    through = pool.submit(misfit.predict, records, _each(coordinates, records), np.array(starts))
    fitted = [*joined(last.segments, *pieces.result()), *fitted_held]
    progress.advance("segments")
    free = joined(whole, *through.result())
    pool.shutdown()
    progress.advance("records")
    traces = [
        Trace(
            run=signal.run,
            guide=signal.run.displacement - signal.slide,
            slide_rate=signal.slide_rate,
            displacement=piecewise[0],
            friction=piecewise[1],
            free_displacement=through[0],
            free_friction=through[1],
            segment_starts=where[0],
            excluded=where[1],
        )
        for signal, piecewise, through, where in zip(signals, fitted, free, cuts, strict=True)
    ]
    order = {signal.run.file: number for number, signal in enumerate(problem.signals)}
    pairs = sorted(zip(traces, signals, strict=True), key=lambda pair: order[pair[1].run.file])
    return Account(
        gaps=tuple(gap for trace, signal in pairs for gap in _gaps(trace, signal)),
        free_runs=tuple(_free_run(trace, signal) for trace, signal in pairs),
        traces=tuple(trace for trace, _ in pairs),
    )


def _held_out(
    problem: Problem, held: tuple[Signals, ...], last: Stage, coordinates: np.ndarray
) -> tuple[list[Segment], Lanes, np.ndarray, np.ndarray]:
    """Segments, lanes and best starts of runs that were not fitted, by way of the shortest segments, and
    which segments stay far worse than the rest."""
    settled: dict[tuple[int, int], np.ndarray] = {}
    short = cut(held, unit(problem))
    for segments in (short, merged(short, math.inf if last.group is None else last.group)):
        lanes = lay_out(held, segments, problem.dataset.rig, problem.scale.force, last.lanes.substeps)
        prior = np.asarray(lanes.start)
        starts = np.array([settled.get((s.run, s.first), prior[i]) for i, s in enumerate(segments)])
        starts, cost = settle(last.misfit, lanes, coordinates, starts)
        freed = unstick(last.misfit, lanes, coordinates, starts, cost)
        if freed is not None:
            starts, cost = settle(last.misfit, lanes, coordinates, freed)
        share = cost / lanes.counted()
        settled = {(s.run, s.first): start for s, start in zip(segments, starts, strict=True)}
    return segments, lanes, starts, share > OUTLIER**2 * np.median(share)


def _cuts(segments: Sequence[Segment], poor: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Where the segments of each run begin, and which of them count little."""
    runs: dict[int, list[int]] = {}
    for index, segment in enumerate(segments):
        runs.setdefault(segment.run, []).append(index)
    return [
        (np.array([segments[i].first for i in mine]), np.asarray(poor)[mine])
        for _, mine in sorted(runs.items())
    ]


def _first(segments: Sequence[Segment], run: int) -> int:
    return next(index for index, segment in enumerate(segments) if segment.run == run)


def _each(coordinates: np.ndarray, lanes: Lanes) -> np.ndarray:
    return np.broadcast_to(coordinates, (len(lanes), len(coordinates)))


def joined(
    segments: Sequence[Segment], displacement: np.ndarray, friction: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Displacement and friction of every run, its segments put end to end."""
    runs: dict[int, list[int]] = {}
    for index, segment in enumerate(segments):
        runs.setdefault(segment.run, []).append(index)

    def join(channel: np.ndarray, mine: list[int]) -> np.ndarray:
        return np.concatenate([channel[i, : segments[i].last - segments[i].first] for i in mine])

    return [(join(displacement, mine), join(friction, mine)) for _, mine in sorted(runs.items())]


def _rms(values: np.ndarray) -> float:
    return math.sqrt(float(np.mean(values**2)))


def _nrms_percent(rms: float, measured: np.ndarray) -> float:
    """The root mean square as a percentage of the standard deviation of what was measured."""
    return 100 * rms / float(np.std(measured))


def _gaps(trace: Trace, signal: Signals) -> list[Gap]:
    run = trace.run
    rms = _rms(trace.displacement - run.displacement)
    gaps = [
        Gap(run.file, "displacement", rms, _nrms_percent(rms, run.displacement), signal.displacement_noise)
    ]
    if run.friction is not None and signal.friction_noise is not None:
        rms = _rms(trace.friction - run.friction)
        gaps.append(Gap(run.file, "friction", rms, _nrms_percent(rms, run.friction), signal.friction_noise))
    return gaps


def _free_run(trace: Trace, signal: Signals) -> FreeRun:
    measured = trace.run.displacement
    rms = _rms(trace.free_displacement - measured)
    return FreeRun(trace.run.file, rms, _nrms_percent(rms, measured), signal.displacement_noise)
