"""The sine that a recorded base follows."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Harmonic:
    """mean + amplitude sin(2 pi frequency t + phase): frequency [Hz], phase [rad] at time zero."""

    frequency: float
    amplitude: float
    phase: float
    mean: float


def fit_harmonic(
    time: NDArray[np.float64], samples: NDArray[np.float64], frequency: float | None = None
) -> Harmonic:
    """The least-squares sine through the samples; its frequency is searched unless given.

    The search starts at the highest line of the spectrum and refines by Gauss-Newton steps on the frequency.
    The record must span at least one cycle. time: uniform [s].
    """
    if frequency is not None:
        return _at(time, samples, frequency)[0]
    span = len(time) * (time[1] - time[0])
    spectrum = np.abs(np.fft.rfft((samples - samples.mean()) * np.hanning(len(samples))))
    found = max(int(np.argmax(spectrum)), 1) / span
    for _ in range(8):
        harmonic, residual = _at(time, samples, found)
        centre = time - time.mean()
        slope = (
            2 * math.pi * centre * harmonic.amplitude * np.cos(2 * math.pi * found * time + harmonic.phase)
        )
        power = np.dot(slope, slope)
        step = float(np.dot(slope, residual) / power) if power else 0.0
        found = max(found + float(np.clip(step, -0.5 / span, 0.5 / span)), 0.5 / span)
        if abs(step) < 1e-9 / span:
            break
    return _at(time, samples, found)[0]


def _at(
    time: NDArray[np.float64], samples: NDArray[np.float64], frequency: float
) -> tuple[Harmonic, NDArray[np.float64]]:
    angle = 2 * math.pi * frequency * time
    design = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
    normal = np.linalg.lstsq(design.T @ design, design.T @ samples, rcond=None)[0]
    sine, cosine, mean = (float(value) for value in normal)
    harmonic = Harmonic(frequency, math.hypot(sine, cosine), math.atan2(cosine, sine), mean)
    return harmonic, samples - design @ np.array([sine, cosine, mean])
