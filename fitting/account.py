"""What a fitted model leaves of every run: piecewise with free starts, and in one free run."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fitting.lanes import Lanes, Misfit
from fitting.newton import settle, unstick
from fitting.problem import Problem
from fitting.progress import Progress
from fitting.result import FreeRun, Gap, Trace
from fitting.segments import Segment, cut, lay_out
from fitting.signals import Signals
from fitting.stage import Stage


@dataclasses.dataclass(frozen=True)
class Account:
    """The gaps by run and channel, the errors of the free runs, and the traces they were taken from."""

    gaps: tuple[Gap, ...]
    free_runs: tuple[FreeRun, ...]
    traces: tuple[Trace, ...]


def account_for(problem: Problem, last: Stage, coordinates: np.ndarray, progress: Progress) -> Account:
    """The account of every run, held out or not, at these coordinates of the unknowns.

    Segments as long as those of the last stage get the starts that suit them best; the free run of a record
    begins as its first segment does and never looks at the record again.
    """
    progress.stage("free runs", 2)
    signals, rig, misfit = problem.signals, problem.dataset.rig, last.misfit
    force, substeps = problem.scale.force, last.lanes.substeps
    segments = cut(signals, last.length)
    lanes = lay_out(signals, segments, rig, force, substeps)
    starts, cost = settle(misfit, lanes, coordinates, np.asarray(lanes.start))
    freed = unstick(misfit, lanes, coordinates, starts, cost)
    if freed is not None:
        starts, cost = settle(misfit, lanes, coordinates, freed)
    share = cost / lanes.counted()
    excluded = share > 4 * np.median(share)
    pieces = _predict(misfit, lanes, coordinates, starts)
    progress.advance("segments")
    whole = [Segment(number, 0, len(signal.run.time)) for number, signal in enumerate(signals)]
    records = lay_out(signals, whole, rig, force, substeps)
    first = [
        next(i for i, segment in enumerate(segments) if segment.run == number)
        for number in range(len(signals))
    ]
    free = _predict(misfit, records, coordinates, starts[first])
    progress.advance("records")

    traces = []
    for number, signal in enumerate(signals):
        mine = [i for i, segment in enumerate(segments) if segment.run == number]
        samples = len(signal.run.time)
        joined = [
            np.concatenate([channel[i, : segments[i].last - segments[i].first] for i in mine])
            for channel in pieces
        ]
        traces.append(
            Trace(
                run=signal.run,
                velocity=signal.velocity,
                displacement=joined[0],
                friction=joined[1],
                free_displacement=free[0][number, :samples],
                free_friction=free[1][number, :samples],
                segment_starts=np.array([segments[i].first for i in mine]),
                excluded=excluded[mine],
            )
        )
    gaps = [gap for trace, signal in zip(traces, signals, strict=True) for gap in _gaps(trace, signal)]
    errors = [_free_run(trace, signal) for trace, signal in zip(traces, signals, strict=True)]
    return Account(tuple(gaps), tuple(errors), tuple(traces))


def _predict(
    misfit: Misfit, lanes: Lanes, coordinates: np.ndarray, starts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    return misfit.predict(lanes, np.broadcast_to(coordinates, (len(lanes), len(coordinates))), starts)


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
