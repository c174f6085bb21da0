"""What measuring chains do to samples on a uniform grid."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from scipy import signal
from scipy.interpolate import CubicSpline

from fitting.blind.formulation import Floats


def lag(samples: Floats, step: float, time: float) -> Floats:
    """time f' = input - f, exact for input that is linear between samples; begins settled."""
    decay = float(np.exp(-step / time))
    gain = 1.0 - time / step * (1.0 - decay)
    return _settled(np.array([gain, 1.0 - decay - gain]), np.array([1.0, -decay]), samples)


def resonance(samples: Floats, step: float, frequency: float, damping: float) -> Floats:
    """f'' + 2 damping w f' + w^2 f = w^2 input, exact for input that is linear between samples; settled.

    frequency = w/(2 pi) [Hz]; damping 1 or more is two lags in a row.
    """
    w = 2.0 * np.pi * frequency
    discrete: Any = signal.cont2discrete(([w * w], [1.0, 2.0 * damping * w, w * w]), step, method="foh")
    numerator, denominator = np.ravel(np.asarray(discrete[0])), np.ravel(np.asarray(discrete[1]))
    return _settled(numerator, denominator, samples)


def _settled(numerator: Floats, denominator: Floats, samples: Floats) -> Floats:
    state = np.asarray(signal.lfilter_zi(numerator, denominator)) * samples[0]
    return np.asarray(signal.lfilter(numerator, denominator, samples, zi=state)[0])


def highpass_second(samples: Floats, step: float, corner: float) -> Floats:
    """Butterworth of second order, corner [Hz], at rest before the first sample."""
    sections = signal.butter(2, corner, "high", fs=1.0 / step, output="sos")
    return np.asarray(signal.sosfilt(sections, samples))


def late(samples: Floats, step: float, time: float) -> Floats:
    """The samples `time` later [s]; before the first sample its value."""
    index = np.arange(len(samples))
    return np.asarray(CubicSpline(index, samples)(np.clip(index - time / step, 0.0, None)))


def all_pass(samples: Floats, step: float, time: float) -> Floats:
    """The delay of a first-order all-pass, (1 - time s/2)/(1 + time s/2)."""
    return 2.0 * lag(samples, step, 0.5 * time) - samples


def moving_average(samples: Floats, step: float, time: float) -> Floats:
    """The mean over the last 2 time [s], exact for input that is linear between samples: a delay of `time`.
    Before it is full it holds what there has been."""
    index = np.arange(float(len(samples)))
    back = np.maximum(index - 2.0 * time / step, 0.0)
    whole = back.astype(int)
    part, slope = back - whole, np.diff(samples, append=samples[-1])
    sums = np.concatenate(([0.0], np.cumsum(0.5 * (samples[1:] + samples[:-1]))))
    before = sums[whole] + part * (samples[whole] + 0.5 * part * slope[whole])
    return np.where(index > back, (sums - before) / np.maximum(index - back, 1e-12), samples)


@njit(cache=True)
def play(samples, half):
    """Follows the samples with a play of `half` to either side."""
    result = np.empty_like(samples)
    at = samples[0]
    for i in range(len(samples)):
        at = min(max(at, samples[i] - half), samples[i] + half)
        result[i] = at
    return result
