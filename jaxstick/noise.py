"""How much white noise a recorded channel carries, without any model of the motion.

A record is cut into windows, and of each its best polynomial is taken off. White noise of standard deviation
s leaves s^2 times a chi-square number of as many degrees of freedom as a window has samples beyond the
polynomial's coefficients; so does a window of a well sampled smooth motion. Corners of a stick-slip record
(breakaway, arrest) raise the remainder of theirs, so that a low quantile of all tells the noise, however many
corners there are in the rest.

Motion that is smooth, but too fast for the polynomial in any window, shows in differences of higher order:
those of order p annihilate polynomials of degree p - 1 over p + 1 samples only, and noise becomes noise of s
sqrt(binomial(2p, p)); the median of the absolute differences, divided by 0.6745, does not see corners as long
as they are few (Hall, Kay & Titterington, Biometrika 77, 1990, on differences; Rousseeuw & Croux, J. Am.
Stat. Assoc. 88, 1993, on the median). They tell the level where they find far less, and where a record is
short.

Measured on 150 simulated data sets of six runs with some 1280 samples each, against what was put in: 0.97
times a displacement's noise (0.93 to 1.02 in nine of ten; by differences alone 0.96, 0.91 to 1.03) and 1.05
times a friction force's, whose corners are many (0.98 to 1.12; 1.09, 1.01 to 1.3), where neighbouring samples
correlate by up to 0.15; 0.78 and 0.83 times where by some 0.4 (0.7 and 1.05, up to 3.4). Of a record of 256
samples a cycle with a damped contact, 10 mm of travel and 7.5 N of friction, displacement noise of 0.8, 8 and
80 um is found as 11 %, 3 % and 1 % too much, friction noise of 0.005, 0.05 and 0.5 N as 21 %, 19 % and 9 %.
What neither tells from noise counts as noise: a contact that rings faster than the sampling resolves, motion
of fewer than about 100 samples a cycle, and up to a fifth more where the steps of the digitisation are ten
times the noise. Noise that is not white but slow is underestimated; `lag1` tells.
"""

from dataclasses import dataclass
from functools import cache
from math import comb, sqrt
from statistics import NormalDist

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

FAST = 1.1
"""So many times what differences find is left in windows in which the motion is too fast or has too many
corners."""

_MEDIAN_TO_SD = 0.6744897501960817
_FEWEST_WINDOWS = 8
_DEGREE = 7
_FOR_LEVEL, _FOR_COLOUR = 16, 24
_QUIETEST = 0.15
_CORRELATIONS = np.linspace(-0.9, 0.9, 37)


@dataclass(frozen=True)
class NoiseEstimate:
    """White noise found in one signal.

    sd: standard deviation, in the signal's unit, at least quantum / sqrt(12); lag1: correlation of one
    sample's noise with the next one's, 0 for white noise, None for a record too short to tell; quantum: the
    step of the digitisation, 0 if none shows.
    """

    sd: float
    lag1: float | None
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
    """The white noise in a uniformly sampled signal of at least 16 samples, shape (samples,)."""
    quantum = _quantum(signal)
    for_colour, for_level = (_remainders(signal, window) for window in (_FOR_COLOUR, _FOR_LEVEL))
    lag1 = None if for_colour is None else _lag1(for_colour)
    sd, order = _by_differences(signal, quantum)
    most = FAST * sd / _shown(lag1 or 0.0, order)
    if for_level is not None and (in_windows := _by_windows(for_level)) <= most:
        sd = in_windows
    return NoiseEstimate(max(sd, quantum / sqrt(12)), lag1, quantum)


def noise_summary(dataset: DataSet) -> tuple[ChannelNoise, ...]:
    """The noise of every channel of every run."""
    return tuple(
        ChannelNoise(run.file, channel, analyse_noise(samples), getattr(dataset.noise, channel))
        for run in dataset.runs
        for channel, samples in run.channels.items()
    )


def noise_levels(dataset: DataSet) -> Noise:
    """Each recorded channel's standard deviation: as stated, else the median of what its runs show.

    What is found is at least RELATIVE_FLOOR of the channel's half range. None for a channel that no run
    recorded.
    """
    return Noise(**{channel: _level(dataset, channel) for channel in CHANNEL_NAMES})


def _level(dataset: DataSet, channel: str) -> float | None:
    stated = getattr(dataset.noise, channel)
    records = [run.channels[channel] for run in dataset.runs if channel in run.channels]
    if stated is not None or not records:
        return stated
    floors = [RELATIVE_FLOOR * float(np.ptp(samples)) / 2 for samples in records]
    return float(np.median(np.maximum([estimate_noise(samples) for samples in records], floors)))


def _by_windows(rest: NDArray[np.float64]) -> float:
    """Standard deviation of white noise that leaves the quietest windows what they have."""
    left = float(np.quantile((rest**2).sum(axis=1), _QUIETEST))
    return sqrt(left / _chi_square(_QUIETEST, rest.shape[1] - _DEGREE - 1))


def _chi_square(share: float, freedom: int) -> float:
    """The quantile of chi-square (Wilson & Hilferty, Proc. Nat. Acad. Sci. 17 (1931) 684)."""
    spread = 2 / (9 * freedom)
    return freedom * (1 - spread + NormalDist().inv_cdf(share) * sqrt(spread)) ** 3


def _by_differences(signal: NDArray[np.float64], quantum: float) -> tuple[float, int]:
    """Standard deviation of white noise with such differences, and their order.

    The order of difference is raised as long as that lowers the estimate by more than its own scatter.
    """
    still_falling = min(0.95, 1 - 3 / sqrt(len(signal)))
    order, sd = ORDERS[0], np.inf
    for higher in ORDERS:
        estimate = _spread(np.diff(signal, higher), quantum) / sqrt(comb(2 * higher, higher))
        if estimate < still_falling * sd:
            order, sd = higher, estimate
    return sd, order


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
    """The step of which all differences between samples are multiples, or 0 if there is none.

    Steps that were written down with fewer digits differ a little, so that it is their mean, and what is left
    of all levels is judged by what is usual between neighbouring ones.
    """
    levels = np.unique(signal)
    steps = np.diff(levels)
    rounding = 16 * np.spacing(np.abs(levels).max())
    steps = steps[steps > rounding]
    if len(steps) == 0:
        return 0.0
    least = float(steps.min())
    quantum = float(steps[steps < 1.5 * least].mean())
    counts = np.rint(steps / quantum)
    quantum = float(steps.sum() / counts.sum())
    lattice = np.abs(steps - counts * quantum).max() < 0.1 * quantum
    return quantum if lattice and quantum > 4 * rounding else 0.0


def _remainders(signal: NDArray[np.float64], window: int) -> NDArray[np.float64] | None:
    """What the best polynomial leaves of every window of so many samples, of which neighbours overlap by two
    thirds: (windows, window), less those in which the digitiser never moved, which say nothing. None for a
    record too short."""
    if len(signal) < _FEWEST_WINDOWS * window:
        return None
    windows = np.lib.stride_tricks.sliding_window_view(signal - signal[0], window)[:: window // 3]
    rest = windows @ _free_of_polynomial(window)
    rest = rest[rest.any(axis=1)]
    return rest if len(rest) >= _FEWEST_WINDOWS else None


@cache
def _free_of_polynomial(window: int) -> NDArray[np.float64]:
    """The projection, (window, window), that takes a window's best polynomial off it."""
    basis = np.polynomial.legendre.legvander(np.linspace(-1, 1, window), _DEGREE)
    orthonormal = np.linalg.qr(basis)[0]
    return np.eye(window) - orthonormal @ orthonormal.T


def _lag1(rest: NDArray[np.float64]) -> float:
    """Correlation of neighbouring samples of the noise, as if it were autoregressive of order one.

    The quieter quarter of the windows, where neither a corner nor fast motion is left, yields the correlation
    of neighbouring remainders. What the polynomial and the choice of quiet windows make of AR(1) noise is
    known, and is undone.
    """
    return float(np.interp(_quiet_correlation(rest), _quiet_correlations(), _CORRELATIONS))


def _quiet_correlation(rest: NDArray[np.float64]) -> float:
    """Products of neighbours over squares in the quieter quarter of the windows; rest: (windows, window)."""
    power = (rest**2).sum(axis=1)
    quiet = np.argsort(power)[: max(len(rest) // 4, _FEWEST_WINDOWS)]
    return float((rest[quiet, 1:] * rest[quiet, :-1]).sum() / power[quiet].sum())


@cache
def _quiet_correlations() -> NDArray[np.float64]:
    """`_quiet_correlation` of noise of each of _CORRELATIONS: a non-decreasing curve, measured on 1500
    windows of made-up noise."""
    free = _free_of_polynomial(_FOR_COLOUR)
    lags = np.abs(np.subtract.outer(np.arange(_FOR_COLOUR), np.arange(_FOR_COLOUR)))
    white = np.random.default_rng(0).normal(size=(1500, _FOR_COLOUR))
    shapes = (np.linalg.cholesky(correlation**lags) for correlation in _CORRELATIONS)
    curve = [_quiet_correlation(white @ shape.T @ free) for shape in shapes]
    return np.maximum.accumulate(curve)
