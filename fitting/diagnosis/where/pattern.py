"""What it is that the records lack follows: the place, the speed, the time, the drive, or a beat of its own.

What is left on a side is regressed on forces that are functions of one thing each. A pattern's share is how
much of the excess it foretells in segments that took no part in its fit (cross-validation; Stone, Journal of
the Royal Statistical Society B 36 (1974) 111), so that a pattern with many coefficients gains nothing by
them. Shares of different patterns overlap: in one run at one frequency, place and phase of the drive say much
the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from fitting.cycle import frequency_of
from fitting.diagnosis.findings import Patterns
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.jobs import predicted
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.phases import AT_REST
from fitting.diagnosis.where.beat import ORDERS, beat_of
from fitting.diagnosis.where.clue import BEAT, FRICTION, MECHANICS, MOMENTS, MOTION
from fitting.diagnosis.where.sides import Side, friction_side, motion_side
from fitting.problem import Problem

PLACES, SPEEDS, DEGREE = 16, 8, 3
"""Splines over place and speed have so many coefficients, and this degree."""
FOLDS, TOGETHER = 3, 2
"""Every third pair of neighbouring segments is foretold by the others."""
SHRUNK, SHRUNK_BY_RUN = 1e-3, 0.03
"""Ridge of a regression, in units of the columns' squares: of what all runs share, and of what each has."""
MOMENT, FEW = 0.05, 0.05
"""What comes in moments has its excess in windows of so much of a natural period, in so few of all."""


class Motion(NamedTuple):
    """The motion in samples of all pieces, one after the other: displacement [m], velocity [m/s] and
    acceleration [m/s^2], the sense of the sliding (0 at rest), time [s], how far along its run it is (-1/2 to
    1/2), its run, and the frequencies of the runs' drives [Hz] (None for none)."""

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    sense: np.ndarray
    time: np.ndarray
    along: np.ndarray
    run: np.ndarray
    drives: tuple[float | None, ...]


def patterns(problem: Problem, model: Model, bench: Bench, point: Point) -> dict[str, Patterns]:
    """The patterns of the sides, by their names, at a point without effects; of a side that says nothing
    there are none."""
    seen = predicted(model, bench, point)
    moving = seen.displacement, seen.velocity
    sliding = model.sliding(bench.lanes, *moving)
    mechanics = MECHANICS if problem.friction_recorded else MOTION
    sides = {
        mechanics: (motion_side(problem, model, bench, point, seen), moving),
        FRICTION: (friction_side(problem, bench, seen.friction, sliding[1]), sliding),
    }
    return {
        name: _patterns(problem, bench, side, *motion)
        for name, (side, motion) in sides.items()
        if side is not None
    }


def _patterns(
    problem: Problem, bench: Bench, side: Side, displacement: np.ndarray, velocity: np.ndarray
) -> Patterns:
    motion = _motion(problem, bench, side, displacement, velocity)
    shares = {name: _share(side, form(motion), ridge) for name, (form, ridge) in FORMS.items()}
    beat = beat_of(problem, bench, side, motion.drives)
    if beat is not None:
        shares[BEAT] = _share(side, _waves(motion, [beat] * len(motion.drives), (1,)), SHRUNK_BY_RUN)
    shares[MOMENTS] = _moments(side, bench.samples(problem.period))
    ordered = sorted(shares.items(), key=lambda item: -item[1])
    return Patterns(side.excess / side.dof, side.significance, side.apart, dict(ordered), beat)


def _motion(
    problem: Problem, bench: Bench, side: Side, displacement: np.ndarray, velocity: np.ndarray
) -> Motion:
    begins, intervals = (np.asarray(v) for v in (bench.lanes.start_time, bench.lanes.interval))
    ends = [(signal.run.time[0], np.ptp(signal.run.time)) for signal in problem.chosen]
    fastest = AT_REST * np.max(np.abs(velocity))
    columns = []
    for piece in side.pieces:
        v, run = velocity[piece.lane, piece.motion], int(bench.run[piece.lane])
        interval = intervals[piece.lane]
        time = begins[piece.lane] + interval * np.arange(piece.motion.start, piece.motion.stop)
        columns.append(
            (
                displacement[piece.lane, piece.motion],
                v,
                np.gradient(v, interval) if len(v) > 1 else np.zeros_like(v),
                np.sign(v) * (np.abs(v) > fastest),
                time,
                (time - ends[run][0]) / ends[run][1] - 0.5,
                np.full(len(v), run),
            )
        )
    drives = tuple(frequency_of(signal.run) for signal in problem.chosen)
    x, v, a, sense, time, along, run = (np.concatenate(column) for column in zip(*columns, strict=True))
    return Motion(x, v, a, sense, time, along, run, drives)


def _spline(values: np.ndarray, count: int) -> np.ndarray:
    """The columns of a spline with so many coefficients over the range of some values."""
    low, high = float(np.min(values)), float(np.max(values))
    if not high > low:
        return np.ones((len(values), 1))
    inner = np.linspace(low, high, count - DEGREE + 1)
    knots = np.concatenate([np.full(DEGREE, low), inner, np.full(DEGREE, high)])
    return BSpline.design_matrix(np.minimum(values, np.nextafter(high, low)), knots, DEGREE).toarray()


def _place(motion: Motion) -> np.ndarray:
    return _spline(motion.x, PLACES)


def _against_by_place(motion: Motion) -> np.ndarray:
    return motion.sense[:, None] * _spline(motion.x, PLACES)


def _speed(motion: Motion) -> np.ndarray:
    return motion.sense[:, None] * _spline(np.abs(motion.v), SPEEDS)


def _one_way(motion: Motion) -> np.ndarray:
    return _spline(np.abs(motion.v), SPEEDS)


def _speeding_up(motion: Motion) -> np.ndarray:
    size = np.clip(motion.a / max(float(np.std(motion.a)), 1e-300), -2.0, 2.0)
    return np.stack([np.abs(motion.sense) * np.sign(motion.a), size], axis=1)


def _along(motion: Motion) -> np.ndarray:
    return motion.along[:, None] * np.stack(
        [np.ones_like(motion.x), motion.x, motion.sense, motion.v], axis=1
    )


def _with_the_drive(motion: Motion) -> np.ndarray:
    return _waves(motion, motion.drives, range(ORDERS + 1))


def _waves(motion: Motion, frequencies: Sequence[float | None], orders: Sequence[int]) -> np.ndarray:
    """Sines and cosines of these orders of every run's frequency, each run with coefficients of its own."""
    columns = []
    for run in np.unique(motion.run).tolist():
        frequency, mine = frequencies[run], motion.run == run
        if frequency is not None:
            angle = 2 * math.pi * frequency * motion.time
            columns += [wave(order * angle) * mine for order in orders for wave in (np.cos, np.sin)]
    return np.stack(columns, axis=1) if columns else np.zeros((len(motion.time), 0))


FORMS: dict[str, tuple[Callable[[Motion], np.ndarray], float]] = {
    "place": (_place, SHRUNK),
    "against the motion, by place": (_against_by_place, SHRUNK),
    "speed": (_speed, SHRUNK),
    "speed, one way": (_one_way, SHRUNK),
    "speeding up": (_speeding_up, SHRUNK),
    "along the runs": (_along, SHRUNK),
    "with the drive": (_with_the_drive, SHRUNK_BY_RUN),
}
"""Forces as functions of the motion (samples, coefficients), and the ridge of their regression."""


def _share(side: Side, columns: np.ndarray, ridge: float) -> float:
    """The share of the excess that these forces foretell in segments that took no part in their fit."""
    count = columns.shape[1]
    if not count or side.excess <= 0:
        return 0.0
    first, grams, answers, felt = 0, [], [], []
    for piece in side.pieces:
        own = columns[first : first + piece.felt.shape[1]]
        first += len(own)
        seen = piece.felt @ own
        felt.append(seen)
        grams.append(seen.T @ seen)
        answers.append(seen.T @ piece.left)
    fold = np.arange(len(felt)) // TOGETHER % FOLDS
    gain = 0.0
    for number in range(FOLDS):
        others = np.flatnonzero(fold != number).tolist()
        gram = sum((grams[n] for n in others), np.zeros((count, count)))
        answer = sum((answers[n] for n in others), np.zeros(count))
        size = np.sqrt(np.diag(gram))
        size[size == 0] = np.inf
        scaled = gram / np.outer(size, size) + ridge * np.eye(count)
        amounts = np.linalg.solve(scaled, answer / size) / size
        gain += sum(
            float(2 * amounts @ answers[n] - amounts @ grams[n] @ amounts)
            for n in np.flatnonzero(fold == number).tolist()
        )
    return float(np.clip(gain / side.excess, 0.0, 1.0))


def _moments(side: Side, period: float) -> float:
    """How much of the excess lies in the few windows that have most of it, lanes that were set apart among
    them; 0 where those few have no more than their share of what varies smoothly."""
    size = max(round(MOMENT * period), 2)
    windows = np.concatenate(
        [
            (piece.left[: len(piece.left) // size * size].reshape(-1, size) ** 2).sum(axis=1)
            for piece in side.pieces
        ]
    )
    few = np.sort(windows - size)[::-1][: max(math.ceil(FEW * len(windows)), 1)]
    inside = max(float(few.sum()) / max(side.excess, 1e-300), 0.0)
    return side.apart_share + (1 - side.apart_share) * min(inside, 1.0)
