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
    interval = float(np.max(np.asarray(bench.lanes.interval)))
    lasts = [float(np.ptp(signal.run.time)) for signal in problem.chosen]
    low = SLOWEST / problem.period
    high = min(FASTEST / problem.period, BELOW_NYQUIST / (2 * interval))
    if not high > low:
        return None
    count = min(math.ceil((high - low) * 2 * max(lasts)), MOST)
    coarse = np.linspace(low, high, max(count, 2))
    gain = _gained(bench, side, drives, lasts, coarse)
    best = int(np.argmax(gain))
    if not gain[best] > 0:
        return None
    step = coarse[1] - coarse[0]
    fine = np.linspace(max(coarse[best] - step, low), coarse[best] + step, FINER)
    return float(fine[np.argmax(_gained(bench, side, drives, lasts, fine))])


def _gained(
    bench: Bench,
    side: Side,
    drives: Sequence[float | None],
    lasts: Sequence[float],
    frequencies: np.ndarray,
) -> np.ndarray:
    """By how much a sine of each frequency lowers chi-square in those runs, which last so long, of whose
    drive it is no harmonic."""
    gain = np.zeros(len(frequencies))
    for run, drive in enumerate(drives):
        pieces = [piece for piece in side.pieces if bench.run[piece.lane] == run]
        if not pieces:
            continue
        gained = _gained_in_a_run(bench, pieces, frequencies)
        if drive is not None:
            order = np.clip(np.round(frequencies / drive), 1, ORDERS)
            gained[np.abs(frequencies - order * drive) * lasts[run] < APART] = 0.0
        gain += gained
    return gain


def _gained_in_a_run(bench: Bench, pieces: Sequence[Piece], frequencies: np.ndarray) -> np.ndarray:
    """By how much a sine of each frequency lowers chi-square in some pieces of a run."""
    step = frequencies[1] - frequencies[0]
    wave, energy = np.zeros(len(frequencies), complex), np.zeros(len(frequencies))
    for piece in pieces:
        interval = float(np.asarray(bench.lanes.interval)[piece.lane])
        start = float(np.asarray(bench.lanes.start_time)[piece.lane]) + interval * piece.motion.start
        samples = piece.felt.shape[1]
        transform = _transform(samples, len(frequencies), interval, float(frequencies[0]), float(step))
        turned = np.exp(-2j * math.pi * frequencies * start)
        wave += transform(piece.felt.T @ piece.left) * turned
        energy += 2 * np.real(transform(piece.lags)) - piece.lags[0]
    return 2 * np.abs(wave) ** 2 / np.maximum(energy, 1e-12 * max(float(np.max(energy)), 1e-300))


def _transform(
    samples: int, count: int, interval: float, first: float, step: float
) -> Callable[[np.ndarray], np.ndarray]:
    """Fourier sums of a series of samples at equally spaced frequencies, the chirp z-transform."""
    turn = 2j * math.pi * interval
    return CZT(samples, count, np.exp(-turn * step), np.exp(turn * first))
