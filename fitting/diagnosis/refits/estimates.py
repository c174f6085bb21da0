"""What a refit found, in the units of an engineer: constants, the rig, strengths and shapes of effects, each
with its interval."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.findings import Parameter
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.freedom import RIG_TOLERANCE
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.confidence import deviations
from fitting.diagnosis.refits.refit import Refit
from fitting.result import Constant
from fitting.unknowns import RIG
from jaxstick.record import CONSTANTS, DataSet

KNOWN = 1.0
"""A shape's logarithm known to no better than this leaves open that the value is nothing: of a value, rather
than its logarithm, so large a share would reach zero."""


class Estimates(NamedTuple):
    """The constants of friction, the properties of the rig that were free within their tolerance, and the
    parameters of every effect asked for; the standard deviation of friction between runs, as a share."""

    constants: tuple[Constant, ...]
    others: tuple[Constant, ...]
    effects: dict[str, tuple[Parameter, ...]]
    between_runs: float


def estimates(
    model: Model,
    dataset: DataSet,
    bench: Bench,
    fit: Refit,
    keys: Sequence[str] = (),
    systematic: np.ndarray | float = 0.0,
) -> Estimates:
    """What a refit found of constants, rig and effects, with 95 % intervals. systematic: mean squares of the
    errors of what is free (coordinates) that no number of samples makes smaller."""
    spread, quantile, between_runs = deviations(model, bench, fit)
    spread = np.sqrt(spread**2 + systematic)
    constants, others = _constants(model, dataset, fit, spread, quantile)
    return Estimates(constants, others, _effects(model, fit, keys, spread, quantile), between_runs)


def _constants(
    model: Model, dataset: DataSet, fit: Refit, spread: np.ndarray, quantile: float
) -> tuple[tuple[Constant, ...], tuple[Constant, ...]]:
    """The constants of friction, and the properties of the rig that were free within their tolerance."""
    stated = {name: getattr(dataset.assumed, name) for name in CONSTANTS}
    stated |= {f"{RIG}{name}": getattr(dataset.rig, name) for name in RIG_TOLERANCE}
    found = []
    for index, deviation in zip(fit.free.tolist(), spread.tolist(), strict=True):
        name = model.names[index]
        if name not in stated:
            continue
        value, low, high = _bounds(model, fit, index, deviation, quantile)
        found.append(
            Constant(
                name=name,
                value=value,
                low=low,
                high=high,
                unit=model.members[index].unit,
                assumed=stated[name],
                standard_error=None if low is None or high is None else (high - low) / (2 * quantile),
                method="covariance",
            )
        )
    friction = tuple(constant for constant in found if constant.name in CONSTANTS)
    return friction, tuple(constant for constant in found if constant.name not in CONSTANTS)


def _effects(
    model: Model, fit: Refit, keys: Sequence[str], spread: np.ndarray, quantile: float
) -> dict[str, tuple[Parameter, ...]]:
    deviation = dict(zip(fit.free.tolist(), spread.tolist(), strict=True))
    out = {}
    for key in keys:
        own = []
        for index in model.of(key).tolist():
            if index not in deviation:
                continue
            value, low, high = _bounds(model, fit, index, deviation[index], quantile)
            if model.members[index].kind == "log" and quantile * deviation[index] >= KNOWN:
                low = None
            name = model.names[index].partition(".")[2]
            own.append(Parameter(name, value, low, high, model.members[index].unit))
        out[key] = tuple(own)
    return out


def _bounds(
    model: Model, fit: Refit, index: int, deviation: float, quantile: float
) -> tuple[float, float | None, float | None]:
    """A parameter's value and 95 % interval in its own unit; an end beyond the bounds is no end."""
    member, at = model.members[index], float(fit.point.coordinates[index])
    low, high = at - quantile * deviation, at + quantile * deviation
    return (
        float(member.to_value(at)),
        float(member.to_value(low)) if low > model.lower[index] and math.isfinite(low) else None,
        float(member.to_value(high)) if high < model.upper[index] and math.isfinite(high) else None,
    )
