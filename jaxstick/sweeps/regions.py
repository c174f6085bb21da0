"""Stop regions: stretches of an amplitude curve over which the number of stops stays the same."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Region:
    """A stretch of a curve with one number of stops (None: not periodic): first and last index, and its ends
    on the axis, halfway to the neighbouring values."""

    stops: float | None
    first: int
    last: int
    low: float
    high: float


def regions(axis: NDArray[np.float64], stops: NDArray[np.float64]) -> list[Region]:
    """The stop regions along an ascending axis, shape (n,); stops, shape (n,), nan where not periodic."""
    key = np.where(np.isfinite(stops), stops, -1.0)
    starts = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    ends = np.r_[starts[1:], len(key)] - 1
    borders = np.r_[axis[0], (axis[starts[1:]] + axis[starts[1:] - 1]) / 2, axis[-1]]
    return [
        Region(
            None if key[first] < 0 else float(key[first]),
            int(first),
            int(last),
            float(borders[number]),
            float(borders[number + 1]),
        )
        for number, (first, last) in enumerate(zip(starts, ends, strict=True))
    ]


def bridged(stops: NDArray[np.float64]) -> NDArray[np.float64]:
    """The numbers of stops along a curve, states without a period taken for one of the region around them
    where it is the same on both sides."""
    known = np.flatnonzero(np.isfinite(stops))
    if len(known) == 0:
        return stops
    position = np.arange(len(stops))
    place = np.searchsorted(known, position)
    before = stops[known[np.clip(np.searchsorted(known, position, side="right") - 1, 0, None)]]
    after = stops[known[np.clip(place, None, len(known) - 1)]]
    inside = (position > known[0]) & (position < known[-1]) & (before == after)
    return np.where(np.isfinite(stops) | ~inside, stops, before)
