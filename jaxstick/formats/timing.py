"""The time axis of a record: made uniform where it nearly is, refused where it is not."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxstick.errors import UserError

UNIFORM_TOLERANCE = 1e-3
"""Sample times this close to a uniform grid, in intervals, are uniform."""

JITTER_LIMIT = 0.5
"""Intervals that differ from the usual one by up to this fraction are resampled; beyond, the record is
refused."""

_MOST_DECIMALS = 9


@dataclass(frozen=True)
class TimeAxis:
    """A uniform time axis, and the recorded times it replaces where samples must be resampled onto it.

    time: uniform [s]; interval: its step [s]; recorded: the times as recorded [s] if the samples stand
    between the points of `time`, else None; notice: what was done, if anything.
    """

    time: NDArray[np.float64]
    interval: float
    recorded: NDArray[np.float64] | None
    notice: str | None

    def resampled(self, samples: NDArray[np.float64]) -> NDArray[np.float64]:
        """The samples on the uniform axis."""
        return samples if self.recorded is None else local_cubic(self.recorded, samples, self.time)


def uniform_axis(
    times: NDArray[np.float64], lines: NDArray[np.int64], file: str, written_unit: float = 1.0
) -> TimeAxis:
    """The uniform axis of recorded times [s].

    Times that a writer rounded to few decimals count as uniform: the grid is the straight line through them.

    Args:
        times: at least two times [s].
        lines: the line of the file on which each stands.
        file: the file's name, for messages.
        written_unit: the unit of the file's time column [s], in which its decimals count.

    Raises:
        UserError: where time stands still or goes back, where samples are missing, and where intervals differ
            from the usual one by more than JITTER_LIMIT.
    """
    steps = np.diff(times)
    _refuse_standing_still(times, steps, lines, file)
    count = len(times)
    index = np.arange(count)
    interval = (times[-1] - times[0]) / (count - 1)
    exact = times[0] + interval * index
    if np.abs(times - exact).max() <= 1e-6 * interval + 4 * np.spacing(np.abs(times).max()):
        return TimeAxis(exact, float(interval), None, None)

    middle = (count - 1) / 2
    slope = np.dot(index - middle, times) / np.dot(index - middle, index - middle)
    line = times.mean() + slope * (index - middle)
    deviation = np.abs(times - line).max()
    rounding = _rounding(times / written_unit) * written_unit
    if deviation <= max(UNIFORM_TOLERANCE * slope, 0.6 * rounding):
        return TimeAxis(line, float(slope), None, None)

    usual = float(np.median(steps))
    _refuse_gaps(times, steps, usual, lines, file)
    notice = (
        f"{file}: the sampling is irregular (intervals of {steps.min():.4g} to {steps.max():.4g} s); the "
        f"record was resampled every {interval:.6g} s by cubic interpolation."
    )
    return TimeAxis(exact, float(interval), times, notice)


def local_cubic(
    times: NDArray[np.float64], samples: NDArray[np.float64], wanted: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Samples at the times `wanted`, by the cubic through the four nearest samples (Lagrange's form).

    Being local it does not ring at the corners of a stick-slip record. times: increasing, at least four.
    """
    first = np.clip(np.searchsorted(times, wanted, side="right") - 2, 0, len(times) - 4)
    result = np.zeros_like(wanted)
    for i in range(4):
        weight = np.ones_like(wanted)
        for j in range(4):
            if j != i:
                weight *= (wanted - times[first + j]) / (times[first + i] - times[first + j])
        result += weight * samples[first + i]
    return result


def _refuse_standing_still(
    times: NDArray[np.float64], steps: NDArray[np.float64], lines: NDArray[np.int64], file: str
) -> None:
    if steps.min() > 0:
        return
    at = int(np.argmax(steps <= 0))
    line, before, now = lines[at + 1], times[at], times[at + 1]
    if now < before:
        raise UserError(f"{file}, line {line}: time goes back from {before:.9g} s to {now:.9g} s.")
    raise UserError(
        f"{file}, line {line}: time stands still at {now:.9g} s; times must increase (are they rounded too "
        "far?)."
    )


def _rounding(times: NDArray[np.float64]) -> float:
    """The decimal step to which all times are rounded, or 0 if they show no rounding."""
    for decimals in range(_MOST_DECIMALS + 1):
        scaled = times * 10.0**decimals
        if np.abs(scaled - np.rint(scaled)).max() < 1e-4:
            return 10.0**-decimals
    return 0.0


def _refuse_gaps(
    times: NDArray[np.float64], steps: NDArray[np.float64], usual: float, lines: NDArray[np.int64], file: str
) -> None:
    off = np.abs(steps / usual - 1)
    if off.max() <= JITTER_LIMIT:
        return
    at = int(np.argmax(off > JITTER_LIMIT))
    where = f"{file}, line {lines[at + 1]}: the interval before {times[at + 1]:.9g} s is {steps[at]:.4g} s"
    if steps[at] > usual:
        raise UserError(f"{where} where {usual:.4g} s is usual: samples are missing or the rate changed.")
    raise UserError(f"{where} where {usual:.4g} s is usual; sampling this irregular is not read.")
