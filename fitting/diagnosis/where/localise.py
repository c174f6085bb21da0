"""Where simulation and record part: the excess of the residuals over their noise, split in several ways."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np

from fitting.account import joined
from fitting.diagnosis.findings import ResidualForce, Where
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.cost import significance
from fitting.diagnosis.lanes.jobs import predicted
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.phases import AT_REST, phases_of
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.which.attribute import Attribution
from fitting.problem import Problem
from fitting.segments import Segment
from fitting.signals import balance
from jaxstick.cycle import cycle_of

ORDERS = 9
TENTHS = 10
SHARPNESS = 4
TERMS = 3
LEAST_GAIN = 0.02


@dataclasses.dataclass(frozen=True)
class Seen:
    """Residuals of all lanes under one hypothesis, sample by sample from the first that counts (lanes,
    samples), in standard deviations, and the motion behind them; `counts` says which samples are real."""

    displacement: np.ndarray
    friction: np.ndarray
    slide_rate: np.ndarray
    force: np.ndarray
    counts: np.ndarray
    read_displacement: np.ndarray
    read_friction: np.ndarray


def see(model: Model, bench: Bench, point: Point) -> Seen:
    """What a hypothesis leaves of every lane."""
    lanes = bench.lanes
    x, f, v, force = predicted(model, bench, point)
    weight = np.asarray(lanes.displacement_weight), np.asarray(lanes.friction_weight)
    columns = (
        weight[0] * (x - np.asarray(lanes.displacement)),
        weight[1] * (f - np.asarray(lanes.friction)),
        model.sliding(lanes, x, v)[1],
        force,
        weight[0] > 0,
        x,
        f,
    )
    return Seen(*(np.take_along_axis(column, _from_first(weight[0]), axis=1) for column in columns))


def _from_first(weight: np.ndarray) -> np.ndarray:
    """Where the samples are that count, the first of every lane first."""
    samples = weight.shape[1]
    return (np.argmax(weight > 0, axis=1)[:, None] + np.arange(samples)) % samples


def localise(
    problem: Problem,
    model: Model,
    bench: Bench,
    segments: Sequence[Segment],
    nominal: Refit,
    seen: Seen,
    found: Attribution,
) -> Where:
    """The excess under the nominal model as fitted to the bench and `seen` there, split by channel, phase,
    direction, run, harmonic, time and side.

    A part that has less than its share of noise counts as zero; of a lane far above the typical one only so
    much counts as still goes for typical.
    """
    share = np.take_along_axis(bench.share, _from_first(bench.share[:, :, 0])[:, :, None], axis=1)
    squares = np.stack([seen.displacement, seen.friction], axis=2) ** 2
    dof = bench.dof()
    noise = (dof / np.maximum(share.sum(axis=(1, 2)), 1))[:, None, None] * share
    over = np.where(share > 0, squares - noise, 0.0) * nominal.weights[:, None, None] ** 2
    phases = phases_of(seen.slide_rate, seen.counts, bench.samples(problem.period))
    by_lane = over.sum(axis=(1, 2))
    total = float(dof.sum())
    return Where(
        channel=shares({"displacement": over[:, :, 0].sum(), "friction": over[:, :, 1].sum()}),
        phase=shares({name: over[mask].sum() for name, mask in phases.items()}),
        direction=shares(
            {"forward": over[seen.slide_rate > 0].sum(), "backward": over[seen.slide_rate <= 0].sum()}
        ),
        run=shares(
            {signal.run.file: over[bench.run == number].sum() for number, signal in enumerate(problem.chosen)}
        ),
        harmonic=_harmonics(problem, segments, seen, over),
        time=_by_time(problem, segments, over),
        side=_sides(model, found),
        excess=float(by_lane.sum()) / total,
        significance=significance(by_lane),
    )


def shares(parts: Mapping[str, float]) -> dict[str, float]:
    """Parts as shares of their sum, negative ones as zero; equal shares where nothing is left."""
    positive = {name: max(float(value), 0.0) for name, value in parts.items()}
    total = sum(positive.values())
    if total <= 0:
        return dict.fromkeys(positive, 1 / len(positive))
    return {name: value / total for name, value in positive.items()}


def _harmonics(
    problem: Problem, segments: Sequence[Segment], seen: Seen, over: np.ndarray
) -> dict[str, float]:
    """The excess at multiples of the drive's frequency, both channels together; "rest" is all else."""
    parts = {str(order): 0.0 for order in range(1, ORDERS + 1)}
    runs = joined(segments, seen.displacement, seen.friction)
    for signal, channels in zip(problem.chosen, runs, strict=True):
        cycle = cycle_of(signal.run)
        if cycle is None:
            continue
        angle = 2 * math.pi * cycle.frequency * signal.run.time
        for series in channels:
            for order in range(1, ORDERS + 1):
                line = np.mean(series * np.exp(-1j * order * angle))
                parts[str(order)] += max(2 * len(series) * float(abs(line)) ** 2 - 2.0, 0.0)
    parts["rest"] = float(over.sum()) - sum(parts.values())
    return shares(parts)


def _by_time(problem: Problem, segments: Sequence[Segment], over: np.ndarray) -> dict[str, float]:
    parts = np.zeros(TENTHS)
    for segment, lane in zip(segments, over.sum(axis=2), strict=True):
        total = len(problem.chosen[segment.run].run.time)
        sample = segment.first + np.arange(segment.last - segment.first)
        tenth = np.minimum(sample * TENTHS // total, TENTHS - 1)
        np.add.at(parts, tenth, lane[: len(sample)])
    return shares({f"{10 * i}-{10 * i + 10} %": float(value) for i, value in enumerate(parts)})


def _sides(model: Model, found: Attribution) -> dict[str, float]:
    """How much of the excess the best effect of each side takes away, sharpened: a side whose best effect
    takes all of it leaves little to one whose best takes half."""
    closed: dict[str, float] = {"mechanics": 0.0, "friction": 0.0, "measurement": 0.0}
    for explanation in found.explanations:
        families = {model.shelf.effects[key].card.family for key in explanation.keys}
        gain = max(found.nominal.misfit - explanation.refit.misfit, 0.0)
        for family in families:
            closed[family] = max(closed[family], gain / len(families))
    return shares({family: value**SHARPNESS for family, value in closed.items()})


def residual_force(problem: Problem, segments: Sequence[Segment], seen: Seen) -> ResidualForce:
    """The force that the equation of motion, closed with the measured motion, asks for beyond the friction of
    the fitted nominal model, which is `seen` in its segments."""
    runs = joined(segments, seen.force, seen.slide_rate)
    rows = []
    for number, (signal, (friction, _)) in enumerate(zip(problem.chosen, runs, strict=True)):
        needed, _ = balance(signal)
        run = signal.run
        moving = (run.displacement, signal.slide_rate, run.time, np.full(len(run.time), number))
        rows.append(np.stack([needed - friction, *moving]))
    force, x, v, time, run = np.concatenate(rows, axis=1)
    resting = np.abs(v) < AT_REST * np.max(np.abs(v))
    return ResidualForce(force, x, v, time, run.astype(int), resting, _sketch(force, x, v))


def _sketch(force: np.ndarray, x: np.ndarray, v: np.ndarray) -> dict[str, float]:
    """Terms chosen one by one, each that which lowers the variance most, as long as it does by a fiftieth."""
    sense = np.sign(v)
    library = {
        "1": np.ones_like(x),
        "x": x,
        "x^2": x**2,
        "x^3": x**3,
        "v": v,
        "v |v|": v * np.abs(v),
        "sign(v)": sense,
        "sign(v) x": sense * x,
        "sign(v) x^2": sense * x**2,
        "x v": x * v,
    }
    scaled = {
        name: column / max(float(np.sqrt(np.mean(column**2))), 1e-300) for name, column in library.items()
    }
    chosen: list[str] = []
    left, coefficients = force, np.zeros(0)
    for _ in range(TERMS):
        gains = {}
        for name in itertools.filterfalse(chosen.__contains__, scaled):
            design = np.stack([scaled[n] for n in (*chosen, name)], axis=1)
            solution = np.linalg.lstsq(design.T @ design, design.T @ force, rcond=None)[0]
            gains[name] = (float(np.mean((force - design @ solution) ** 2)), solution)
        best = min(gains, key=lambda name: gains[name][0])
        if gains[best][0] > (1 - LEAST_GAIN) * float(np.mean(left**2)):
            break
        chosen.append(best)
        coefficients = gains[best][1]
        left = force - np.stack([scaled[n] for n in chosen], axis=1) @ coefficients
    order = np.argsort(-np.abs(coefficients))
    return {chosen[i]: float(coefficients[i]) for i in order}
