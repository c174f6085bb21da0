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

    def at(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Its values at these times [s]."""
        return self.mean + self.amplitude * np.sin(2 * math.pi * self.frequency * time + self.phase)


def fit_harmonic(
    time: NDArray[np.float64], samples: NDArray[np.float64], frequency: float | None = None
) -> Harmonic:
    """The least-squares sine through the samples; its frequency is searched unless given.

    The search starts at the highest line of the spectrum and refines by Gauss-Newton steps on the frequency,
    with what amplitude, phase and mean make of them projected out (Golub, Pereyra, SIAM Journal on Numerical
    Analysis 10 (1973) 413). The record must span at least one cycle. time: uniform [s].
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
        slope = _left(_design(time, found), slope)
        power = np.dot(slope, slope)
        step = float(np.dot(slope, residual) / power) if power else 0.0
        found = max(found + float(np.clip(step, -0.5 / span, 0.5 / span)), 0.5 / span)
        if abs(step) < 1e-9 / span:
            break
    return _at(time, samples, found)[0]


def _at(
    time: NDArray[np.float64], samples: NDArray[np.float64], frequency: float
) -> tuple[Harmonic, NDArray[np.float64]]:
    design = _design(time, frequency)
    sine, cosine, mean = _weights(design, samples).tolist()
    harmonic = Harmonic(frequency, math.hypot(sine, cosine), math.atan2(cosine, sine), mean)
    return harmonic, _left(design, samples)


def _design(time: NDArray[np.float64], frequency: float) -> NDArray[np.float64]:
    angle = 2 * math.pi * frequency * time
    return np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)


def _weights(design: NDArray[np.float64], samples: NDArray[np.float64]) -> NDArray[np.float64]:
    weights, *_ = np.linalg.lstsq(design.T @ design, design.T @ samples, rcond=None)
    return np.asarray(weights, np.float64)


def _left(design: NDArray[np.float64], samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """What the columns of the design leave of the samples."""
    return samples - design @ _weights(design, samples)
