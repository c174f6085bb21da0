"""The periodic states behind the counterparts of the paper's figures."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxstick.nominal import nominal
from jaxstick.oscillator import Start
from jaxstick.outcome import outcome
from jaxstick.parts.drive import SineDrive
from jaxstick.record import AssumedConstants, KnownRig
from jaxstick.side_by_side import Journey, side_by_side
from jaxstick.sweep import sweep

SAMPLES = 1200
"""Samples of a trace a cycle."""

CYCLES = 24
EARLY = 7
"""Cycles after which the paper read its amplitudes: five to ten."""


@dataclass(frozen=True, eq=False)
class Response:
    """A motion after 24 cycles from rest: two cycles of time [s], displacement [m], velocity [m/s], friction
    force [N] and base [m], from a crossing of the base upwards.

    amplitude [m]; stops a cycle; harmonics: the displacement's first 15 amplitudes [m]; change: how much a
    cycle differs from the one before it, over the amplitude; early: the amplitude of the seventh cycle over
    that of the last, less 1.
    """

    ratio: float
    frequency: float
    time: NDArray[np.float64]
    displacement: NDArray[np.float64]
    velocity: NDArray[np.float64]
    friction: NDArray[np.float64]
    base: NDArray[np.float64]
    amplitude: float
    stops: float
    harmonics: NDArray[np.float64]
    change: float
    early: float


def responses(
    rig: KnownRig, constants: AssumedConstants, ratios: tuple[float, ...], amplitude: float
) -> list[Response]:
    """The motions at these frequency ratios under a base of this amplitude [m]."""
    found = []
    for ratio in ratios:
        frequency = ratio * rig.natural_frequency
        interval = 1 / (frequency * SAMPLES)
        oscillator = nominal(rig, constants, SineDrive(frequency, amplitude))
        journey = Journey(oscillator, Start(), 0.0, interval, CYCLES * SAMPLES + 1)
        found.append(_response(side_by_side([journey])[0], rig, ratio, frequency, amplitude))
    return found


def _response(path, rig: KnownRig, ratio: float, frequency: float, amplitude: float) -> Response:
    x = np.asarray(path.x)
    last, before = x[-SAMPLES:], x[-2 * SAMPLES : -SAMPLES]
    read = outcome(
        last,
        interval=1 / (frequency * SAMPLES),
        frequency=frequency,
        natural_frequency=rig.natural_frequency,
    )
    early = np.ptp(x[(EARLY - 1) * SAMPLES : EARLY * SAMPLES]) / np.ptp(last) - 1
    shown = slice(-2 * SAMPLES - 1, None)
    time = np.arange(2 * SAMPLES + 1) / (frequency * SAMPLES)
    return Response(
        ratio,
        frequency,
        time,
        x[shown],
        np.asarray(path.v)[shown],
        np.asarray(path.friction)[shown],
        amplitude * np.sin(2 * math.pi * frequency * time),
        read.amplitude,
        read.stops,
        2 * np.abs(np.fft.rfft(last))[1:16] / SAMPLES,
        float(np.max(np.abs(last - before)) / read.amplitude),
        float(early),
    )


@dataclass(frozen=True, eq=False)
class Curve:
    """Periodic states over ascending frequency ratios, shape (n,): amplitude over base amplitude, stops a
    cycle (nan: not periodic), residual, and the largest even harmonic over the first."""

    label: str
    ratios: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    stops: NDArray[np.float64]
    residual: NDArray[np.float64]
    even: NDArray[np.float64]


def curve(
    label: str, rig: KnownRig, constants: AssumedConstants, ratios: NDArray[np.float64], amplitude: float
) -> Curve:
    """The periodic states over these frequency ratios under a base of this amplitude [m]."""
    found = sweep(rig, constants, ratios=ratios, amplitudes=amplitude)
    stops = np.where(found["period"] > 0, found["stops"], np.nan)
    even = np.max(found["harmonics"][:, 1::2], axis=1) / found["harmonics"][:, 0]
    return Curve(label, ratios, found["amplitude_ratio"], stops, found["residual"], even)
