"""The same scheme as a numba loop over lanes, one lane after the other on every core."""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np

from scripts.benchmark_parts.lanes import SAMPLES, Lanes


@numba.njit(fastmath=True, inline="always")
def _clip(value: Any, upper: Any) -> Any:
    return min(max(value, 0.0), upper)


@numba.njit(parallel=True, fastmath=True, cache=False)
def _march(
    constants: tuple[np.ndarray, ...], interval: np.ndarray, steps: int, displacement: np.ndarray
) -> None:
    masses, stiffnesses, drive_stiffnesses, dampings, As, Bs, Cs, Ds, k1s, frequencies, amplitudes = constants
    for lane in numba.prange(len(masses)):
        per_mass, stiffness, damping = 1 / masses[lane], stiffnesses[lane], dampings[lane]
        A, B, C, D, k1 = As[lane], Bs[lane], Cs[lane], Ds[lane], k1s[lane]
        push = drive_stiffnesses[lane] * amplitudes[lane]
        h = interval[lane] / steps
        turn = 2 * math.pi * frequencies[lane] * h
        twelfth = k1 * h * h * per_mass / 12
        fitting = twelfth * (1 + twelfth)
        mobility = h / 2 * per_mass
        x, deflection, before = 0.0, 0.0, -(A + C)
        behind, ahead = 0.0, 0.0
        displacement[lane, 0] = 0.0
        for sample in range(1, displacement.shape[1]):
            for count in range((sample - 1) * steps + 1, sample * steps + 1):
                slide = h * ahead
                expected = 1.5 * ahead - 0.5 * behind
                x += slide
                force = push * math.sin(turn * count) - stiffness * x - damping * expected
                free = force * per_mass
                trial = deflection + slide
                sense = -1.0 if trial < 0 else 1.0
                limit = A * math.exp(-B * abs(expected)) + C
                excess = k1 * abs(trial) - limit
                loads = slide * sense > 0
                slid = before > 0
                change = excess - before
                size = abs(change) if change != 0 else 1.0
                share = 0.0
                if loads:
                    if slid:
                        share = _clip(excess, size) / size if change < 0 else 1.0
                    elif change > 0:
                        share = _clip(excess + 0.5 * size, size) / size
                if share > 0:
                    shortfall = 0.0 if slid else 0.5 * (1 - share) * (1 - share) * change
                    mean = sense * (shortfall - limit)
                else:
                    mean = -k1 * trial
                coasting = ahead + h / 2 * free + mobility * mean
                mean -= share * D * coasting / (1 + mobility * share * D)
                if loads and excess > 0:
                    deflection, before = sense * limit / k1, excess
                else:
                    deflection, before = trial, min(excess, 0.0)
                reached = (free + mean * per_mass) / (1 + (1 - share) * fitting)
                behind, ahead = ahead, ahead + h * reached
            displacement[lane, sample] = x


def simulate(lanes: Lanes, steps: int, workers: int | None = None) -> np.ndarray:
    """Displacement at the samples, shape (lanes, samples)."""
    displacement = np.empty((lanes.size, SAMPLES))
    before: Any = numba.get_num_threads()
    if workers is not None:
        numba.set_num_threads(workers)
    try:
        _march(tuple(lanes), lanes.interval, steps, displacement)
    finally:
        numba.set_num_threads(before)
    return displacement
