"""A frequency of its own: what oscillates in all runs alike, whatever the frequency of their drives.

The periodogram of what is left, weighed as a regression on a force that oscillates weighs it, coherent along
each run and summed over runs (Lomb, Astrophysics and Space Science 39 (1976) 447).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import CZT

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.where.sides import Piece, Side
from fitting.problem import Problem

SLOWEST, FASTEST, BELOW_NYQUIST = 0.25, 30.0, 0.8
"""A beat has so many cycles in a natural period, and at most so much of the Nyquist frequency."""
MOST, FINER = 3000, 41
"""So many frequencies are tried at most, and so many around the best."""
ORDERS = 7
"""What repeats itself with the drive has so many harmonics."""
APART = 1.5
"""So many cycles in a run set a beat apart from each of them."""


def beat_of(problem: Problem, bench: Bench, side: Side, drives: Sequence[float | None]) -> float | None:
    """The frequency [Hz] of a sine that all runs show, each in a phase of its own, where it takes most of
    chi-square; of those that are no harmonics of a run's drive there. None where there is no room for any.
    `drives`: the frequencies of the runs' drives [Hz], None for none."""
    coarse = frequencies(problem, bench)
    if coarse is None:
        return None
    gain = gained_by_run(problem, bench, side, drives, coarse).sum(axis=0)
    best = int(np.argmax(gain))
    return refined(problem, bench, side, drives, coarse, best) if gain[best] > 0 else None


def frequencies(problem: Problem, bench: Bench) -> np.ndarray | None:
    """The frequencies [Hz] that are tried, so close that no beat is missed between them; None where there is
    no room for any."""
    interval = float(np.max(np.asarray(bench.lanes.interval)))
    low = SLOWEST / problem.period
    high = min(FASTEST / problem.period, BELOW_NYQUIST / (2 * interval))
    if not high > low:
        return None
    count = min(math.ceil((high - low) * 2 * max(durations(problem))), MOST)
    return np.linspace(low, high, max(count, 2))


def refined(
    problem: Problem,
    bench: Bench,
    side: Side,
    drives: Sequence[float | None],
    coarse: np.ndarray,
    best: int,
) -> float:
    """The frequency [Hz] where it takes most of chi-square, around one of those that were tried."""
    step = coarse[1] - coarse[0]
    fine = np.linspace(max(coarse[best] - step, coarse[0]), coarse[best] + step, FINER)
    return float(fine[np.argmax(gained_by_run(problem, bench, side, drives, fine).sum(axis=0))])


def gained_by_run(
    problem: Problem,
    bench: Bench,
    side: Side,
    drives: Sequence[float | None],
    tried: np.ndarray,
) -> np.ndarray:
    """By how much a sine of each frequency that is tried lowers chi-square in each run (runs, frequencies); 0
    in those of whose drive it is a harmonic, and in those that say nothing."""
    gain = np.zeros((len(drives), len(tried)))
    for run, (drive, lasts) in enumerate(zip(drives, durations(problem), strict=True)):
        pieces = [piece for piece in side.pieces if bench.run[piece.lane] == run]
        if not pieces:
            continue
        gain[run] = _gained_in_a_run(bench, pieces, tried)
        if drive is not None:
            order = np.clip(np.round(tried / drive), 1, ORDERS)
            gain[run, np.abs(tried - order * drive) * lasts < APART] = 0.0
    return gain


def durations(problem: Problem) -> list[float]:
    """How long each run lasts [s]."""
    return [float(np.ptp(signal.run.time)) for signal in problem.chosen]


def _gained_in_a_run(bench: Bench, pieces: Sequence[Piece], tried: np.ndarray) -> np.ndarray:
    """By how much a sine of each frequency lowers chi-square in some pieces of a run."""
    step = tried[1] - tried[0]
    wave, energy = np.zeros(len(tried), complex), np.zeros(len(tried))
    for piece in pieces:
        interval = float(np.asarray(bench.lanes.interval)[piece.lane])
        start = float(np.asarray(bench.lanes.start_time)[piece.lane]) + interval * piece.motion.start
        samples = piece.felt.shape[1]
        transform = _transform(samples, len(tried), interval, float(tried[0]), float(step))
        turned = np.exp(-2j * math.pi * tried * start)
        wave += transform(piece.felt.T @ piece.left) * turned
        energy += 2 * np.real(transform(piece.lags)) - piece.lags[0]
    return 2 * np.abs(wave) ** 2 / np.maximum(energy, 1e-12 * max(float(np.max(energy)), 1e-300))


def _transform(
    samples: int, count: int, interval: float, first: float, step: float
) -> Callable[[np.ndarray], np.ndarray]:
    """Fourier sums of a series of samples at equally spaced frequencies, the chirp z-transform."""
    turn = 2j * math.pi * interval
    return CZT(samples, count, np.exp(-turn * step), np.exp(turn * first))
