"""A sweep's outcomes as arrays over its axes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jaxstick.sweeps.plan import AXES, Plan

OUTCOMES = ("amplitude_ratio", "stops", "period")
"""The columns that plots and summaries are made of."""


@dataclass(frozen=True)
class Field:
    """Outcomes over the axes of a sweep that have more than one value.

    axes: their values by name, those of the frequency ratio last; outcomes: arrays by column, each of the
    shape of the axes, not a number where there is none (stops of a lane that is not periodic).
    """

    axes: Mapping[str, NDArray[np.float64]]
    outcomes: Mapping[str, NDArray[np.float64]]

    def at(self, chosen: Mapping[str, int]) -> "Field":
        """The field where the named axes have these indices."""
        index = tuple(chosen.get(name, slice(None)) for name in self.axes)
        return Field(
            {name: values for name, values in self.axes.items() if name not in chosen},
            {name: values[index] for name, values in self.outcomes.items()},
        )


class FieldBuilder:
    """Fills a field chunk by chunk, keeping three numbers a lane."""

    def __init__(self, plan: Plan) -> None:
        names = [name for name in plan.varied if name != "ratios"]
        names += ["ratios"] if len(plan.axes["ratios"]) > 1 or not names else []
        self._axes = {name: np.asarray(plan.axes[name]) for name in names}
        self._shape = tuple(len(values) for values in self._axes.values())
        self._outcomes = {name: np.full(self._shape, np.nan) for name in OUTCOMES}

    def add(self, columns: Mapping[str, NDArray[Any]]) -> None:
        """Takes in the lanes of a chunk, wherever they lie on the axes."""
        index = tuple(_nearest(values, _along(columns, name)) for name, values in self._axes.items())
        for name, outcome in self._outcomes.items():
            outcome[index] = np.asarray(columns[name], float)

    def field(self) -> Field:
        """The field of all lanes taken in."""
        order = [np.argsort(values) for values in self._axes.values()]
        stops, period = self._outcomes["stops"], self._outcomes["period"]
        outcomes = {**self._outcomes, "stops": np.where(period > 0, stops, np.nan)}
        return Field(
            {name: values[rank] for (name, values), rank in zip(self._axes.items(), order, strict=True)},
            {name: values[np.ix_(*order)] for name, values in outcomes.items()},
        )


def _along(columns: Mapping[str, NDArray[Any]], axis: str) -> NDArray[np.float64]:
    """Where the lanes lie on an axis."""
    static = columns["A_n"] + columns["C_n"]
    if axis == "level":
        return static
    if axis == "friction_ratio":
        return columns["C_n"] / np.where(static == 0, 1.0, static)
    return columns[_COLUMNS[axis]]


_COLUMNS = {
    "ratios": "frequency_ratio",
    "amplitudes": "base_amplitude_m",
    "A": "A_n",
    "B": "B_s_per_m",
    "C": "C_n",
    "D": "D_n_s_per_m",
    "k1": "k1_n_per_m",
}


def _nearest(values: NDArray[np.float64], found: NDArray[np.float64]) -> NDArray[np.int64]:
    """For each of `found` the index of the nearest of `values`."""
    order = np.argsort(values)
    ranked = values[order]
    right = np.clip(np.searchsorted(ranked, found), 1, len(ranked) - 1) if len(ranked) > 1 else None
    if right is None:
        return np.zeros(len(found), np.int64)
    left = right - 1
    return order[np.where(found - ranked[left] <= ranked[right] - found, left, right)]


def curves(field: Field, along: str) -> Iterator[tuple[dict[str, int], Field]]:
    """The field cut into curves along one axis: the indices on the other axes, and the curve."""
    others = [name for name in field.axes if name != along]
    for index in np.ndindex(*(len(field.axes[name]) for name in others)):
        chosen = dict(zip(others, index, strict=True))
        yield chosen, field.at(chosen)


def said(field: Field, chosen: Mapping[str, int]) -> str:
    """Where on the other axes a curve lies, in words: 'base amplitude 8 mm, C 6.4 N'."""
    return ", ".join(
        f"{AXES[name].meaning} {AXES[name].shown(field.axes[name][index])}" for name, index in chosen.items()
    )
