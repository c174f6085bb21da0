"""Cuts runs into short segments and lays them out as lanes."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np
from scipy.interpolate import CubicSpline

from fitting.cycle import whole_cycles
from fitting.history import History
from fitting.lanes import Lanes
from fitting.signals import Signals, base_motion, natural_period
from jaxstick.parts.drive import Extent, RecordedDrive
from jaxstick.record import KnownRig

KNOTS_A_PERIOD = 40
LEAST_SAMPLES = 12
START_FREEDOM = 10.0


@dataclasses.dataclass(frozen=True)
class Segment:
    """Samples `first` to `last` (exclusive) of run number `run`."""

    run: int
    first: int
    last: int


def cut(signals: Sequence[Signals], unit: float) -> list[Segment]:
    """Segments of about `unit` seconds each that cover every run."""
    segments = []
    for number, signal in enumerate(signals):
        samples = len(signal.run.time)
        count = max(1, samples // max(LEAST_SAMPLES, round(unit / signal.run.interval)))
        edges = np.linspace(0, samples, count + 1).round().astype(int)
        segments += [Segment(number, int(a), int(b)) for a, b in itertools.pairwise(edges)]
    return segments


def merged(segments: Sequence[Segment], count: float) -> list[Segment]:
    """Longer segments, each of about `count` consecutive ones of the same run; infinity merges whole runs."""
    out = []
    for number, group in itertools.groupby(segments, key=lambda segment: segment.run):
        parts = list(group)
        wanted = max(1, round(len(parts) / count))
        edges = np.linspace(0, len(parts), wanted + 1).round().astype(int)
        out += [Segment(number, parts[a].first, parts[b - 1].last) for a, b in itertools.pairwise(edges)]
    return out


def lay_out(
    signals: Sequence[Signals],
    segments: Sequence[Segment],
    rig: KnownRig,
    force_scale: float,
    substeps: int,
    beyond: int = 0,
) -> Lanes:
    """The segments as lanes. `rig` is the hypothesis' own rig; `force_scale` [N] the size of the friction;
    `beyond` says by how many samples, which do not count, each lane at least goes on after its last."""
    samples = max(segment.last - segment.first for segment in segments) + beyond
    refine = max(_refinement(signal) for signal in signals)
    splines = [_drive_pieces(signal, refine) for signal in signals]
    whole = [whole_cycles(signal.run) * refine for signal in signals]
    extents = [
        _extent(base[:samples], force[:samples])
        for (base, force), samples in zip(splines, whole, strict=True)
    ]
    histories = [History.of(signal, natural_period(signal.run.rig)) for signal in signals]
    known = list(zip(histories, splines, strict=True))
    columns = [_lane(*known[segment.run], segment, samples, refine, force_scale) for segment in segments]
    stacked = jax.tree.map(lambda *each: np.stack(each), *columns)
    runs = [signals[segment.run].run for segment in segments]
    drive = RecordedDrive(
        start=stacked["start_time"],
        interval=stacked["interval"] / refine,
        base=stacked["base"],
        force=stacked["force"],
        whole=Extent(*np.array([extents[segment.run] for segment in segments]).T),
    )
    shift = {
        name: np.array([getattr(run.rig, name) - getattr(rig, name) for run in runs])
        for name in ("mass", "stiffness", "drive_stiffness", "damping", "drive_damping")
    }
    return Lanes(
        rig_shift=shift,
        drive=drive,
        start_time=stacked["start_time"],
        interval=stacked["interval"],
        displacement=stacked["displacement"],
        friction=stacked["friction"],
        displacement_weight=stacked["displacement_weight"],
        friction_weight=stacked["friction_weight"],
        start=stacked["start"],
        start_deviation=stacked["start_deviation"],
        before=stacked["before"],
        substeps=substeps,
    )


def _refinement(signal: Signals) -> int:
    """Into how many pieces a sample interval is split so that a sine that was not recorded is met well."""
    run = signal.run
    if run.base is not None or run.frequency is None:
        return 1
    return max(1, math.ceil(KNOTS_A_PERIOD * run.frequency * run.interval))


def _drive_pieces(signal: Signals, refine: int) -> tuple[np.ndarray, np.ndarray]:
    """Cubic coefficients of base and force on a grid `refine` times finer than the samples, which goes on for
    one sample after the last, or for as many as the base is known ahead; the force then stays as it is."""
    time, interval = signal.run.time, signal.run.interval
    more = max(1, len(signal.ahead))
    knots = time[0] + interval / refine * np.arange((len(time) - 1 + more) * refine + 1)
    if _refinement(signal) > 1:
        base = CubicSpline(knots, base_motion(signal.run, knots)[0])
    else:
        ahead = time[-1] + interval * np.arange(1, len(signal.ahead) + 1)
        base = CubicSpline(np.concatenate([time, ahead]), np.concatenate([signal.base, signal.ahead]))
    force = _on_grid(CubicSpline(time, signal.force), knots[: len(time) * refine + 1])
    stays = np.repeat(force[-1:], (more - 1) * refine, axis=0)
    return _on_grid(base, knots), np.concatenate([force, stays])


def _extent(base: np.ndarray, force: np.ndarray) -> tuple[float, ...]:
    """How far base, its rate and force go: sqrt(2) standard deviations of each."""
    deviations = [float(np.std(column)) for column in (base[:, 3], base[:, 2], force[:, 3])]
    return tuple(math.sqrt(2) * deviation for deviation in deviations)


def _on_grid(spline: CubicSpline, knots: np.ndarray) -> np.ndarray:
    left = knots[:-1] + 1e-9 * np.diff(knots)
    derivatives = [spline(left, order) for order in (3, 2, 1, 0)]
    scale = (6.0, 2.0, 1.0, 1.0)
    return np.stack([value / factor for value, factor in zip(derivatives, scale, strict=True)], axis=1)


def _lane(
    history: History,
    pieces: tuple[np.ndarray, np.ndarray],
    segment: Segment,
    samples: int,
    refine: int,
    force_scale: float,
) -> dict[str, Any]:
    signal, run = history.signal, history.signal.run
    index = np.minimum(segment.first + np.arange(samples), segment.last - 1)
    counts = (segment.first + np.arange(samples) < segment.last).astype(float)
    piece = segment.first * refine + np.arange((samples - 1) * refine)
    piece = np.minimum(piece, len(pieces[0]) - 1)
    has_friction = run.friction is not None
    friction_weight = counts / signal.friction_noise if signal.friction_noise else np.zeros(samples)
    start = [run.displacement[index[0]], signal.velocity[index[0]], signal.friction[index[0]]]
    deviation = [
        START_FREEDOM * signal.displacement_noise,
        START_FREEDOM * signal.velocity_deviation,
        force_scale * (0.3 if has_friction else 1.0),
    ]
    return {
        "base": pieces[0][piece],
        "force": pieces[1][piece],
        "start_time": np.array(run.time[segment.first]),
        "interval": np.array(run.interval),
        "displacement": run.displacement[index],
        "friction": run.friction[index] if run.friction is not None else np.zeros(samples),
        "displacement_weight": counts / signal.displacement_noise,
        "friction_weight": friction_weight,
        "start": np.array(start),
        "start_deviation": np.array(deviation),
        "before": history.before(segment.first),
    }
