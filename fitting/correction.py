"""A fitted model in the terms of a rig file: what a user keeps of a fit or a diagnosis."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from jaxstick.effect import AbstractEffect
from jaxstick.hypothesis import Hypothesis
from jaxstick.parameter import find, parameters
from jaxstick.record import CONSTANTS, AssumedConstants, Effects, KnownRig

RIG_NUMBERS = tuple(each.name for each in dataclasses.fields(KnownRig) if each.type in (float, "float"))


@dataclasses.dataclass(frozen=True)
class Correction:
    """A rig with the constants of its friction and the effects that act on it, all values in SI.

    It holds for the data set as a whole; a run whose rig is stated to differ from the data set's differs by
    as much from `rig`.
    """

    rig: KnownRig
    constants: AssumedConstants
    effects: Effects


def correction_of(hypothesis: Hypothesis, rig: KnownRig) -> Correction:
    """What a fitted hypothesis, whose nominal oscillator has no wrapped parts, says in a rig file; `rig` is
    the stated one."""
    nominal = hypothesis.nominal
    found = {name: float(find(nominal, f"rig.{name}").of(nominal)) for name in RIG_NUMBERS}
    constants = {name: float(find(nominal, name).of(nominal)) for name in CONSTANTS}
    return Correction(
        dataclasses.replace(rig, **found),
        AssumedConstants(**constants),
        {key: _within_bounds(hypothesis.effects[key]) for key in hypothesis.order},
    )


def shifted(correction: Correction, run: KnownRig, stated: KnownRig) -> KnownRig:
    """The corrected rig of a run whose own rig is `run`, in a data set whose rig is stated as `stated`."""
    changed = {
        name: getattr(correction.rig, name) + getattr(run, name) - getattr(stated, name)
        for name in RIG_NUMBERS
        if getattr(run, name) != getattr(stated, name)
    }
    return dataclasses.replace(correction.rig, friction_against=run.friction_against, **changed)


def _within_bounds(effect: AbstractEffect) -> Mapping[str, float]:
    """The effect's parameters; one that a search left a rounding error beyond its bound is on it."""
    return {
        place.path[-1]: float(np.clip(place.of(effect), place.parameter.lower, place.parameter.upper))
        for place in parameters(effect)
    }
