"""How much white noise a recorded channel carries, without any model of the motion.

Differences of order p annihilate polynomials of degree p - 1, so a well sampled smooth motion all but
vanishes while white noise of standard deviation s becomes noise of standard deviation s sqrt(binomial(2p,
p)). The corners of a stick-slip record (breakaway, arrest) disturb p + 1 differences each; the median of the
absolute differences, divided by 0.6745, does not see them as long as they are few (Hall, Kay & Titterington,
Biometrika 77, 1990, on differences; Rousseeuw & Croux, J. Am. Stat. Assoc. 88, 1993, on the median).

Measured on simulated stick-slip records of 256 samples a cycle with a damped contact, 10 mm of travel and 7.5
N of friction: displacement noise of 0.8, 8 and 80 um is found within 5 %, friction noise of 0.005, 0.05 and
0.5 N as 40 %, 20 % and 2 % too much. What the differences cannot tell from noise counts as noise: a contact
that rings faster than the sampling resolves, and motion of fewer than about 100 samples a cycle, raise the
estimate several times. Noise that is not white but slow is underestimated, to a half where neighbouring
samples correlate by 0.6; `lag1` tells.
"""

from dataclasses import dataclass
from functools import cache
from math import comb, sqrt

import numpy as np
from numpy.typing import NDArray

from jaxstick.record import CHANNEL_NAMES, DataSet, Noise

ORDERS = range(2, 11)
"""Orders of difference that are tried."""

MOST = 0.7
"""Slower noise than of this correlation cannot be told from motion."""

COLOURED = 0.5
"""Noise whose neighbouring samples correlate by more than this is not white."""

RELATIVE_FLOOR = 1e-6
"""Where nothing is stated, no channel counts as cleaner than this fraction of its half range."""

_MEDIAN_TO_SD = 0.6744897501960817
_WINDOW, _DEGREE, _FEWEST_WINDOWS = 24, 7, 8
_CORRELATIONS = np.linspace(-0.9, 0.9, 37)


@dataclass(frozen=True)
class NoiseEstimate:
    """White noise found in one signal.

    sd: standard deviation, in the signal's unit, at least quantum / sqrt(12); lag1: correlation of one
    sample's noise with the next one's, 0 for white noise, None for a record too short to tell; order: of the
    differences it was found with; quantum: the step of the digitisation, 0 if none shows.
    """

    sd: float
    lag1: float | None
    order: int
    quantum: float

    @property
    def coloured(self) -> bool:
        """Whether lag1 is beyond COLOURED, so that `sd` misjudges the noise or still holds some motion."""
        return self.lag1 is not None and abs(self.lag1) > COLOURED


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of one channel of one run: what was found, and the standard deviation stated (None: nothing)."""

    file: str
    channel: str
    found: NoiseEstimate
    stated: float | None


def estimate_noise(signal: NDArray[np.float64]) -> float:
    """Standard deviation of the white noise in a uniformly sampled signal of at least 16 samples, in its
    unit."""
    return analyse_noise(signal).sd


def analyse_noise(signal: NDArray[np.float64]) -> NoiseEstimate:
    """The white noise in a uniformly sampled signal of at least 16 samples, shape (samples,).

    The order of difference is raised as long as that lowers the estimate by more than its own scatter.
    """
    quantum = _quantum(signal)
    still_falling = min(0.95, 1 - 3 / sqrt(len(signal)))
    order, sd = ORDERS[0], np.inf
    for higher in ORDERS:
        estimate = _spread(np.diff(signal, higher), quantum) / sqrt(comb(2 * higher, higher))
        if estimate < still_falling * sd:
            order, sd = higher, estimate
    return NoiseEstimate(max(sd, quantum / sqrt(12)), _lag1(signal), order, quantum)


def noise_summary(dataset: DataSet) -> tuple[ChannelNoise, ...]:
    """The noise of every channel of every run."""
    return tuple(
        ChannelNoise(run.file, channel, analyse_noise(samples), getattr(dataset.noise, channel))
        for run in dataset.runs
        for channel, samples in run.channels.items()
    )


def noise_levels(dataset: DataSet) -> Noise:
    """Each recorded channel's standard deviation: as stated, else the median of what its runs show.

    What is found allows for neighbouring samples that correlate in every run (motion that passes for noise
    does so in some), and is at least RELATIVE_FLOOR of the channel's half range. None for a channel that no
    run recorded.
    """
    return Noise(**{channel: _level(dataset, channel) for channel in CHANNEL_NAMES})


def _level(dataset: DataSet, channel: str) -> float | None:
    stated = getattr(dataset.noise, channel)
    records = [run.channels[channel] for run in dataset.runs if channel in run.channels]
    if stated is not None or not records:
        return stated
    found = [analyse_noise(samples) for samples in records]
    floors = [RELATIVE_FLOOR * float(np.ptp(samples)) / 2 for samples in records]
    least = min((estimate.lag1 for estimate in found if estimate.lag1 is not None), default=0.0)
    levels = [estimate.sd / _shown(least, estimate.order) for estimate in found]
    return float(np.median(np.maximum(levels, floors)))


def _shown(correlation: float, order: int) -> float:
    """What differences of that order show of autoregressive noise, over what they show of white noise that is
    as strong; neighbouring samples correlate by `correlation`."""
    weights = np.array([comb(order, k) * (-1) ** k for k in range(order + 1)], float)
    lags = np.abs(np.subtract.outer(np.arange(order + 1), np.arange(order + 1)))
    white = weights @ weights
    return sqrt(float(weights @ min(max(correlation, 0.0), MOST) ** lags @ weights) / white)


def _spread(differences: NDArray[np.float64], quantum: float) -> float:
    """Standard deviation of the bulk of the differences.

    Digitised differences are multiples of the quantum, on which a median moves in steps; evenly spread
    numbers of one quantum's width are added for the median and their variance is taken off again.
    """
    if quantum == 0:
        return float(np.median(np.abs(differences))) / _MEDIAN_TO_SD
    golden = np.modf(np.arange(1, len(differences) + 1) * 0.6180339887498949)[0]
    dithered = float(np.median(np.abs(differences + quantum * (golden - 0.5)))) / _MEDIAN_TO_SD
    return sqrt(max(dithered**2 - quantum**2 / 12, 0.0))


def _quantum(signal: NDArray[np.float64]) -> float:
    """The step of which all differences between samples are multiples, or 0 if there is none."""
    levels = np.unique(signal)
    steps = np.diff(levels)
    rounding = 16 * np.spacing(np.abs(levels).max())
    steps = steps[steps > rounding]
    if len(steps) == 0:
        return 0.0
    quantum = float(steps.min())
    counts = (levels - levels[0]) / quantum
    lattice = np.abs(counts - np.rint(counts)).max() < 0.05
    return quantum if lattice and quantum > 4 * rounding else 0.0


def _lag1(signal: NDArray[np.float64]) -> float | None:
    """Correlation of neighbouring samples of the noise, as if it were autoregressive of order one.

    The record is cut into windows, each freed of its best polynomial; the quieter quarter of them, where
    neither a corner nor fast motion is left, yields the correlation of neighbouring remainders. What the
    polynomial and the choice of quiet windows make of AR(1) noise is known, and is undone.
    """
    free, expected = _window_statistics()
    windows = len(signal) // _WINDOW
    rest = (signal - signal[0])[: windows * _WINDOW].reshape(windows, _WINDOW) @ free
    # A window in which the digitiser never moved says nothing.
    rest = rest[rest.any(axis=1)]
    if len(rest) < _FEWEST_WINDOWS:
        return None
    return float(np.interp(_quiet_correlation(rest), expected, _CORRELATIONS))


def _quiet_correlation(rest: NDArray[np.float64]) -> float:
    """Products of neighbours over squares in the quieter quarter of the windows; rest: (windows, window)."""
    power = (rest**2).sum(axis=1)
    quiet = np.argsort(power)[: max(len(rest) // 4, _FEWEST_WINDOWS)]
    return float((rest[quiet, 1:] * rest[quiet, :-1]).sum() / power[quiet].sum())


@cache
def _window_statistics() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What takes a window's best polynomial off it, and `_quiet_correlation` of noise of each of
    _CORRELATIONS.

    The projection, (window, window), and a non-decreasing curve, measured on 1500 windows of made-up noise.
    """
    basis = np.polynomial.legendre.legvander(np.linspace(-1, 1, _WINDOW), _DEGREE)
    orthonormal = np.linalg.qr(basis)[0]
    free = np.eye(_WINDOW) - orthonormal @ orthonormal.T
    lags = np.abs(np.subtract.outer(np.arange(_WINDOW), np.arange(_WINDOW)))
    white = np.random.default_rng(0).normal(size=(1500, _WINDOW))
    shapes = (np.linalg.cholesky(correlation**lags) for correlation in _CORRELATIONS)
    curve = [_quiet_correlation(white @ shape.T @ free) for shape in shapes]
    return free, np.maximum.accumulate(curve)
