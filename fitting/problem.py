"""What a fit is about: the signals of a data set, a hypothesis about them, and which parameters are free."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from fitting.of_the_rig import of_the_rig, room
from fitting.opening import Scales, opening, scales
from fitting.segments import LEAST_SAMPLES
from fitting.settings import Settings
from fitting.signals import Signals, natural_period, read_signals
from fitting.unknowns import RIG, Unknown, Unknowns
from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.hypothesis import Hypothesis, effects_at_null
from jaxstick.noise import noise_levels
from jaxstick.nominal import effects_of, nominal
from jaxstick.parameter import find, parameters, replace
from jaxstick.parts.drive import SineDrive
from jaxstick.record import CONSTANTS, AssumedConstants, DataSet, Effects, KnownRig
from jaxstick.sizes import size_of

PRIOR_SHARE = {"damping": 0.2, "drive_damping": 0.2}
PRIOR_SHARE_ELSE = 0.02
TYPICAL_DECAYS = (4.0, 12.0, 40.0)
"""B times the top speed: weakening over a quarter, a twelfth, a fortieth of the speeds in the data."""
FAR = 50.0
"""By what factor a shape may differ from the typical one."""
ROOM = 3.0
"""How many times less or more than what is assumed B and k1 may be, whatever the data show."""
SCATTER = {"A": 0.7, "B": 0.9, "C": 0.15, "D": 1.0, "k1": 1.2}
"""Standard deviation of the logarithm of random starting values around those read off the data."""


@dataclasses.dataclass(frozen=True)
class Problem:
    """A data set ready to be fitted.

    `signals` are those of every run, `chosen` those of the runs that are not held out; `opening` the
    constants read off the data; `period` the time scale of the rig [s].
    """

    dataset: DataSet
    signals: tuple[Signals, ...]
    chosen: tuple[Signals, ...]
    scale: Scales
    opening: dict[str, float]
    hypothesis: Hypothesis
    unknowns: Unknowns
    period: float

    @property
    def friction_recorded(self) -> bool:
        """Whether any of the chosen runs has the friction force."""
        return any(signal.run.friction is not None for signal in self.chosen)


def pose(dataset: DataSet, settings: Settings) -> Problem:
    """The problem of fitting this data set.

    The effects that its rig file states act as stated; those that `settings` names are free, and begin as
    stated where they are.

    Raises UserError for an effect that is not on the shelf, a parameter that cannot be freed, and a run too
    short for a segment.
    """
    stated = effects_of(dataset)
    effects = {
        **stated,
        **{key: e for key, e in effects_at_null(settings.effects).items() if key not in stated},
    }
    for run in dataset.runs:
        if len(run.time) < LEAST_SAMPLES:
            raise UserError(
                f"{run.file}: {len(run.time)} samples are fewer than the {LEAST_SAMPLES} of a segment; "
                "record longer or take the run out of rig.toml."
            )
    noise = noise_levels(dataset)
    signals = tuple(read_signals(run, noise) for run in dataset.runs)
    chosen = tuple(signal for signal in signals if not signal.run.hold_out)
    scale = scales(chosen)
    first = opening(chosen, scale)
    oscillator = nominal(dataset.rig, AssumedConstants(**first), SineDrive(frequency=1.0))
    period = time_scale(chosen)
    hypothesis = Hypothesis(
        oscillator, _at_typical(effects, settings.effects, dataset.effects, scale, period)
    )
    members = [
        *_constants(scale, dataset.assumed),
        *_of_effects(hypothesis, settings.effects, dataset, scale, period),
    ]
    members += [_freed(hypothesis, dataset.rig, name) for name in settings.free]
    return Problem(dataset, signals, chosen, scale, first, hypothesis, Unknowns(tuple(members)), period)


def beginnings(problem: Problem, settings: Settings) -> np.ndarray:
    """Coordinates where the descents begin (starts, unknowns): read off the data, as assumed today, typical
    laws of the friction level read off, and points scattered around the first."""
    hypothesis, unknowns, first = problem.hypothesis, problem.unknowns, problem.opening
    rest = {
        name: float(find(hypothesis, name).of(hypothesis)) for name in unknowns.names if name not in first
    }
    stated = {name: getattr(problem.dataset.assumed, name) for name in CONSTANTS}
    points = [unknowns.coordinates({**first, **rest})]
    if all(value is not None for value in stated.values()):
        points.append(unknowns.coordinates({**stated, **rest}))
    for decay in TYPICAL_DECAYS:
        level = first["A"] + first["C"]
        typical = {"A": 0.2 * level, "B": decay / problem.scale.speed, "C": 0.8 * level, "D": 0.0}
        points.append(unknowns.coordinates({**first, **typical, **rest}))
    more = scatter(problem, points[0], settings.starts, settings.seed)
    return np.array([*points, *more][: max(1, settings.starts)])


def scatter(problem: Problem, coordinates: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Random points (count, unknowns) around one: the constants by factors, the rest by tenths of scale."""
    random = np.random.default_rng(seed)
    unknowns = problem.unknowns
    points = np.tile(coordinates, (count, 1))
    for index, unknown in enumerate(unknowns.members):
        draw = random.standard_normal(count)
        if unknown.name in SCATTER:
            value = np.maximum(unknown.to_value(points[:, index]), 1e-3 * unknown.scale)
            value = np.clip(value * np.exp(SCATTER[unknown.name] * draw), unknown.lower, unknown.upper)
            points[:, index] = unknown.to_coordinate(value)
        elif unknown.kind == "linear":
            points[:, index] += 0.1 * draw
    return np.clip(points, unknowns.lower, unknowns.upper)


def time_scale(signals: Sequence[Signals]) -> float:
    """The natural period of the rig [s], the longest of all runs; 400 samples where it has no springs."""
    return max(natural_period(signal.run.rig) or 400 * signal.run.interval for signal in signals)


def _constants(scale: Scales, assumed: AssumedConstants) -> list[Unknown]:
    """A, B, C, D, k1 within bounds set by the force F, speed V and travel X that the data show: A, C and D V
    up to 3 F; B V from 0.5 to 2000 and k1 from F/X to 5000 F/X, which a contact may be stiffer than and
    weakening sharper, so that both are also let be from a third to three times what is assumed."""
    force, speed, travel = scale.force, scale.speed, scale.displacement
    return [
        Unknown("A", "N", 0.0, 3 * force, "linear", force),
        _around(assumed.B, Unknown("B", "s/m", 0.5 / speed, 2000 / speed, "log")),
        Unknown("C", "N", 0.0, 3 * force, "linear", force),
        Unknown("D", "N s/m", 0.0, 3 * force / speed, "linear", force / speed),
        _around(assumed.k1, Unknown("k1", "N/m", force / travel, 5000 * force / travel, "log")),
    ]


def _around(stated: float | None, unknown: Unknown) -> Unknown:
    """An unknown whose bounds leave room around what is stated, if that is more than nothing."""
    if not stated:
        return unknown
    low, high = stated / ROOM, stated * ROOM
    return dataclasses.replace(unknown, lower=min(unknown.lower, low), upper=max(unknown.upper, high))


def natural_size(unit: str, scale: Scales, period: float) -> float:
    """What a unit amounts to on this rig: newtons are its friction, metres its stroke, seconds its period."""
    return size_of(unit, scale.force, scale.displacement, period)


def _of_effects(
    hypothesis: Hypothesis, keys: Sequence[str], dataset: DataSet, scale: Scales, period: float
) -> list[Unknown]:
    """The parameters of the effects that are free, bounded by what their units amount to on this rig and what
    it has of their kind, and wide enough for what is stated; shapes, which have no null, are searched as
    logarithms around their typical size where they have one sign."""
    found, stated = [], dataset.effects
    for key in dict.fromkeys(keys):
        for place in parameters(hypothesis.effects[key]):
            kind, own = place.parameter, place.path[-1]
            name, natural = f"{key}.{own}", natural_size(kind.unit, scale, period)
            if kind.null is not None or (kind.typical and kind.signed):
                reach = max(3 * natural, 2 * abs(stated.get(key, {}).get(own, 0.0)))
                less, more = room(of_the_rig(kind.unit, dataset.rig, scale), reach)
                lower, upper = max(kind.lower, -less), min(kind.upper, more)
                found.append(Unknown(name, kind.unit, lower, upper, "linear", natural))
            elif kind.typical:
                typical = kind.typical * natural
                value = stated.get(key, {}).get(own, typical)
                lower = max(kind.lower, min(typical, value) / FAR)
                upper = min(kind.upper, max(typical, value) * FAR)
                found.append(Unknown(name, kind.unit, lower, upper, "log", 1.0))
    return found


def _at_typical(
    effects: dict[str, AbstractEffect], keys: Sequence[str], stated: Effects, scale: Scales, period: float
) -> dict[str, AbstractEffect]:
    """The effects; shapes of those that are free suit the rig where none is stated: they are of the size that
    is typical on it."""
    out = dict(effects)
    for key in keys:
        shapes = {
            place.path[-1]: place.parameter.typical * natural_size(place.parameter.unit, scale, period)
            for place in parameters(effects[key])
            if place.parameter.null is None and place.parameter.typical and not place.parameter.signed
        }
        given = stated.get(key, {})
        out[key] = replace(effects[key], {name: size for name, size in shapes.items() if name not in given})
    return out


def _freed(hypothesis: Hypothesis, rig: KnownRig, name: str) -> Unknown:
    known = {place.path[-1]: place.parameter for place in parameters(hypothesis.nominal.rig)}
    if name not in known:
        raise UserError(
            f"{name!r} is not a parameter of the rig; those that can be freed are {', '.join(known)}."
        )
    value = getattr(rig, name)
    if value <= 0:
        raise UserError(
            f"{name!r} is stated as {value:g}; only a parameter with a stated value can be freed."
        )
    deviation = PRIOR_SHARE.get(name, PRIOR_SHARE_ELSE) * value
    return Unknown(f"{RIG}{name}", known[name].unit, value / 3, value * 3, "log", 1.0, value, deviation)
