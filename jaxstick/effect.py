"""What an effect is: a candidate explanation that can be attached to an oscillator."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

import equinox as eqx
import numpy as np

from jaxstick.oscillator import Oscillator


@dataclasses.dataclass(frozen=True)
class Card:
    """An effect in an engineer's words: title, symptom in records, explanation, remedy on the rig, source."""

    title: str
    family: str
    symptom: str
    explanation: str
    remedy: str
    source: str


class Leftover(NamedTuple):
    """What a model without the effect leaves of records: samples, in any order, of time [s], how far [m]
    and how fast [m/s] the mass slides over its guide as modelled, the modelled friction force on it [N], and
    what the recorded one has beyond it [N]."""

    time: np.ndarray
    slide: np.ndarray
    slide_rate: np.ndarray
    friction: np.ndarray
    beyond: np.ndarray


class AbstractEffect(eqx.Module):
    """A physical or measuring effect that the nominal oscillator lacks.

    Its first parameter is its strength; at the strength's null value the effect changes nothing, so that
    every hypothesis contains the nominal model. Further parameters give its shape and mean nothing at null.
    `traces` says what it changes in base, displacement and force once the rig's properties and the constants
    of friction are fitted, where other effects change the same: two that share a trace are aliases.
    `traces_in_motion` are those where the friction force was not recorded, so that the constants may give all
    forces another scale; None where they are the same. `changes` says whether it is nothing new that it
    changes along a run: it does so by itself, or another effect of the shelf is just that.
    """

    card: eqx.AbstractClassVar[Card]
    traces: ClassVar[tuple[str, ...]] = ()
    traces_in_motion: ClassVar[tuple[str, ...] | None] = None
    changes: ClassVar[bool] = False

    @classmethod
    def traces_seen(cls, friction_recorded: bool) -> tuple[str, ...]:
        """Its traces in records with the friction force or without."""
        if friction_recorded or cls.traces_in_motion is None:
            return cls.traces
        return cls.traces_in_motion

    @classmethod
    def on_chain(cls) -> bool:
        """Whether it is a fault of the measuring chain, along which the order of faults tells."""
        return cls.card.family == "measurement"

    @classmethod
    def read_off(cls, leftover: Leftover) -> Mapping[str, float]:
        """Shape parameters by name that may be read off what a model without the effect leaves; most shapes
        are found by trying a few, and this says nothing of them."""
        return {}

    @abc.abstractmethod
    def attach(self, oscillator: Oscillator) -> Oscillator:
        """The oscillator with the part that this effect concerns wrapped."""
