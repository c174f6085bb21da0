"""The signature of an effect: one cycle of a nominal rig without it and with it."""

from __future__ import annotations

import dataclasses

import numpy as np

from jaxstick.hypothesis import Hypothesis, effects_at_null
from jaxstick.nominal import nominal
from jaxstick.oscillator import Start
from jaxstick.parameter import Parameter, parameters, replace
from jaxstick.parts.drive import SineDrive
from jaxstick.record import AssumedConstants, KnownRig
from jaxstick.side_by_side import Journey, side_by_side
from jaxstick.simulate import Trajectory
from jaxstick.sizes import size_of

RIG = KnownRig(2.38, 1986.0, 1986.0, 4.53, 0.0)
CONSTANTS = AssumedConstants(1.5, 40.0, 6.0, 2.0, 99300.0)
DRIVE = SineDrive(1.5, 10.325e-3)
"""The rig of 1987 at a third of its natural frequency, where it stops twice a cycle."""

CYCLES = 6
SAMPLES_PER_CYCLE = 500


@dataclasses.dataclass(frozen=True)
class Signature:
    """The last of some cycles from rest, without and with the effect; `values` are the parameters it has.

    Displacement and friction are those that the instrument reads.
    """

    key: str
    title: str
    values: dict[str, tuple[float, str]]
    without: Trajectory
    with_effect: Trajectory


def signature(key: str) -> Signature:
    """The signature of the effect called `key`, its strength at the size that is to be expected.

    Raises UserError for a key that is not on the shelf.
    """
    effect = effects_at_null((key,))[key]
    period = 1 / RIG.natural_frequency
    level = (CONSTANTS.A or 0.0) + (CONSTANTS.C or 0.0)

    def expected(kind: Parameter) -> float:
        return (kind.typical or 0.0) * size_of(kind.unit, level, float(DRIVE.base_amplitude), period)

    kinds = {place.path[-1]: place.parameter for place in parameters(effect)}
    strength = next(iter(kinds))
    changed = {
        name: expected(kind)
        for name, kind in kinds.items()
        if kind.typical is not None and (kind.null is None or name == strength)
    }
    oscillator = nominal(RIG, CONSTANTS, DRIVE)
    hypotheses = Hypothesis(oscillator), Hypothesis(oscillator, {key: replace(effect, changed)})
    interval = 1 / float(DRIVE.frequency) / SAMPLES_PER_CYCLE
    samples = CYCLES * SAMPLES_PER_CYCLE + 1
    journeys = [Journey(each.oscillator(), Start(), 0.0, interval, samples) for each in hypotheses]
    last = slice(-SAMPLES_PER_CYCLE - 1, None)
    runs = [
        Trajectory(*(np.asarray(channel)[last] for channel in run))  # pyright: ignore[reportArgumentType]
        for run in side_by_side(journeys)
    ]
    values = {name: (value, kinds[name].unit) for name, value in changed.items()}
    return Signature(key, effect.card.title, values, runs[0], runs[1])
