"""What records lack, apart by side: the motion once friction is known, and friction where the mass slides.

The equation of motion m x'' + c x' + K x = drive + F is closed with the friction force F that was measured:
what the displacement lacks then, dx - H dF (H: the response of the free rig to a force), is the fault of the
mechanics or of a sensor, whatever friction does. Where no friction force was recorded it is all that the
motion shows. Mass, stiffness and damping are known within a tolerance: what other values of them would do is
no part of it. What the measured force lacks beside the model's is told in slip, where a law of friction asks
for little else than the speed; in stick, and around it, the force does what the rest of the rig asks for.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm, solve_triangular

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model, Prediction
from fitting.diagnosis.lanes.phases import phases_of
from fitting.diagnosis.noise.linked import response, rigs_of
from fitting.problem import Problem

LOST = 25.0
"""A lane that leaves so many times as much as the typical one has lost an event: it is set apart."""
FEWEST_SAMPLES = 20
"""A lane with fewer samples, or a side with fewer in all, says nothing."""


class Piece(NamedTuple):
    """One lane of a side: what is left in standard deviations (rows), what a force on the mass (samples)
    makes of it (rows, samples), the sums of that with itself by lag (samples), and how many independent
    numbers it amounts to. `lane` counts on the bench, `motion` are the samples of it."""

    lane: int
    left: np.ndarray
    felt: np.ndarray
    lags: np.ndarray
    dof: float
    motion: slice


@dataclasses.dataclass(frozen=True)
class Side:
    """The pieces of a side, those that fit far worse than the rest set apart, and how much of the excess
    these have."""

    pieces: tuple[Piece, ...]
    apart: int
    apart_share: float

    @property
    def excess(self) -> float:
        """By how much chi-square exceeds its degrees of freedom in what is not set apart."""
        return float(sum(piece.left @ piece.left - piece.dof for piece in self.pieces))

    @property
    def dof(self) -> float:
        return float(sum(piece.dof for piece in self.pieces))

    @property
    def significance(self) -> float:
        """How many standard deviations of the sums by lane the excess lies above zero."""
        over = np.array([piece.left @ piece.left - piece.dof for piece in self.pieces])
        return float(over.sum() / max(np.std(over) * np.sqrt(len(over)), 1e-300))


def motion_side(problem: Problem, model: Model, bench: Bench, point: Point, seen: Prediction) -> Side | None:
    """What the motion lacks where friction is as it was measured, every lane's start and the rig left open.
    `seen`: what the bench shows at the point."""
    lanes, measured = bench.lanes, problem.friction_recorded
    known: dict[tuple[float, ...], _Free] = {}
    rigs, pieces = rigs_of(model, bench, point), []
    for lane, interval in enumerate(np.asarray(lanes.interval).tolist()):
        counts = np.flatnonzero(bench.share[lane, :, 0])
        if len(counts) < FEWEST_SAMPLES:
            continue
        signal = problem.chosen[bench.run[lane]]
        motion = slice(int(counts[0]), int(counts[-1]) + 1)
        samples = motion.stop - motion.start
        noise = signal.displacement_noise, signal.friction_noise if measured else 0.0
        if noise[1] is None:
            continue
        key = (*noise, *rigs[lane], interval, samples)
        if key not in known:
            known[key] = _freed(*key)
        white, moves, felt, lags = known[key]
        lacks = np.asarray(lanes.displacement)[lane, motion] - seen.displacement[lane, motion]
        if measured:
            lacks = lacks - moves @ (np.asarray(lanes.friction)[lane, motion] - seen.friction[lane, motion])
        pieces.append(Piece(lane, white @ lacks, felt, lags, samples - 2.0, motion))
    side = _side(pieces)
    return None if side is None else _with_the_rig_open(side, bench, seen)


def _with_the_rig_open(side: Side, bench: Bench, seen: Prediction) -> Side:
    """The side less what another mass, stiffness and damping would do."""
    intervals = np.asarray(bench.lanes.interval)
    columns = []
    for piece in side.pieces:
        x, v = (values[piece.lane, piece.motion] for values in (seen.displacement, seen.velocity))
        columns.append(piece.felt @ np.stack([np.gradient(v, intervals[piece.lane]), v, x], axis=1))
    left = np.concatenate([piece.left for piece in side.pieces])
    amounts = np.linalg.lstsq(np.concatenate(columns), left, rcond=None)[0]
    pieces = [
        piece._replace(left=piece.left - own @ amounts)
        for piece, own in zip(side.pieces, columns, strict=True)
    ]
    return dataclasses.replace(side, pieces=tuple(pieces))


def friction_side(
    problem: Problem, bench: Bench, friction: np.ndarray, slide_rate: np.ndarray
) -> Side | None:
    """What the measured friction force lacks, beside that of a model, where the mass slides as there; None
    where it was not recorded."""
    if not problem.friction_recorded:
        return None
    weight, share = bench.lanes.weights()[:, :, 1], bench.share[:, :, 1]
    slips = phases_of(slide_rate, share > 0, bench.samples(problem.period))["slip"]
    lacks = weight * (np.asarray(bench.lanes.friction) - friction)
    pieces = []
    for lane in range(len(bench.lanes)):
        rows = np.flatnonzero(slips[lane] & (share[lane] > 0))
        if len(rows) < 2:
            continue
        motion = slice(int(rows[0]), int(rows[-1]) + 1)
        samples = motion.stop - motion.start
        felt, lags = np.zeros((len(rows), samples)), np.zeros(samples)
        felt[np.arange(len(rows)), rows - rows[0]] = weight[lane, rows]
        lags[0] = float(np.sum(felt**2))
        pieces.append(Piece(lane, lacks[lane, rows], felt, lags, float(share[lane, rows].sum()), motion))
    return _side(pieces)


def _side(pieces: list[Piece]) -> Side | None:
    pieces = [piece for piece in pieces if np.all(np.isfinite(piece.left))]
    if sum(len(piece.left) for piece in pieces) < FEWEST_SAMPLES:
        return None
    squares = np.array([piece.left @ piece.left for piece in pieces])
    dof = np.array([piece.dof for piece in pieces])
    each = squares / np.maximum(dof, 1.0)
    kept = each <= LOST * max(float(np.median(each)), 1.0)
    over = np.maximum(squares - dof, 0.0)
    share = float(over[~kept].sum() / max(over.sum(), 1e-300))
    return Side(tuple(p for p, k in zip(pieces, kept, strict=True) if k), int((~kept).sum()), share)


class _Free(NamedTuple):
    """The matrix that takes what the motion lacks to standard deviations and takes out of it what another
    start would do; the response of the displacement to a force; both together, and their sums by lag."""

    white: np.ndarray
    moves: np.ndarray
    felt: np.ndarray
    lags: np.ndarray


def _freed(
    displacement: float,
    friction: float,
    mass: float,
    stiffness: float,
    damping: float,
    interval: float,
    samples: int,
) -> _Free:
    """`displacement` [m] and `friction` [N] are the noises of the sensors."""
    moves = response(interval, mass, stiffness, damping, samples)
    step = expm(interval * np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]]))
    states = [np.eye(2)]
    for _ in range(samples - 1):
        states.append(step @ states[-1])
    starts = np.stack(states)[:, 0, :]
    covariance = displacement**2 * np.eye(samples) + friction**2 * moves @ moves.T
    white = solve_triangular(np.linalg.cholesky(covariance), np.eye(samples), lower=True)
    basis = np.linalg.qr(white @ starts)[0]
    white = white - basis @ (basis.T @ white)
    felt = white @ moves
    alike = felt.T @ felt
    return _Free(white, moves, felt, np.array([np.trace(alike, lag) for lag in range(samples)]))
