"""A low-pass filter in the force channel."""

from __future__ import annotations

import dataclasses
from typing import ClassVar, NamedTuple

from jaxtyping import Array, Float

from jaxstick.effect import AbstractEffect, Card
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import parameter, part_of_it
from jaxstick.parts.force_link import AbstractForceLink
from jaxstick.parts.instrument import AbstractInstrument, Past
from jaxstick.parts.lag import Lag, Trail, lagged, settled, trailed
from jaxstick.parts.motion import Motion, Scalar


class ForceLowpass(AbstractEffect):
    """The recorded force f lags: f + time f' + curvature time^2 f'' = F.

    A curvature near 0 is one RC stage, 1/4 two equal ones, 1/2 a Butterworth filter of second order. Filters
    of higher order come as late but sharper: by the share `further` of the time a further RC stage lags
    behind that filter, which lags by the rest of it.
    """

    card: ClassVar[Card] = Card(
        title="Low-pass filter in the force channel",
        family="measurement",
        symptom="The recorded force comes late and rounded: edges at breakaway, arrest and reversal are "
        "smeared over some milliseconds, while slow changes are merely late.",
        explanation=(
            "A filter against noise or aliasing, or the bandwidth of the gauge amplifier, acts on the force "
            "and not, or not alike, on the displacement. Force against speed opens to a loop that grows with "
            "frequency, easily taken for frictional memory; but then the motion would follow, and "
            "here the equation of motion fails with the recorded force. A pure delay comes as late but keeps "
            "the edges sharp."
        ),
        remedy="Give every channel the same filter; switch the force filter off for one run; tap the table "
        "and record how fast the channel falls.",
        source="E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill 2004, on "
        "first- and second-order instruments; A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal "
        "Processing, 3rd ed., Pearson 2010, on Butterworth filters.",
    )
    time: Float[Array, ""] | float = parameter(
        "s",
        "delay of slow changes",
        lower=0.0,
        upper=0.05,
        null=0.0,
        typical=0.01,
        default=0.0,
    )
    curvature: Float[Array, ""] | float = parameter(
        "1",
        "order of the filter: 0 one RC stage, 1/4 two, 1/2 Butterworth of second order",
        lower=0.0,
        upper=0.5,
        typical=0.1,
        default=0.1,
    )
    further: Float[Array, ""] | float = part_of_it("share of the delay that a further RC stage has")

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(
            oscillator,
            instrument=_FilteredForce(
                oscillator.instrument,
                (1 - self.further) * self.time,
                self.curvature,
                self.further * self.time,
            ),
        )


class _Stages(NamedTuple):
    """The filter, and the further stage behind it."""

    filter: Lag
    further: Trail


class _FilteredForce(AbstractForceLink):
    inner: AbstractInstrument
    time: Scalar
    curvature: Scalar
    further: Scalar

    def begin(self, motion: Motion, friction: Scalar, past: Past) -> _Stages:
        before = settled(friction, past.change(friction, self.time))
        read = friction - past.change(friction, self.time + self.further)
        return _Stages(before, Trail(read, before.level))

    def follow(self, own: _Stages, motion: Motion, friction: Scalar, step: Scalar) -> _Stages:
        before = lagged(own.filter, friction, step, self.time, self.curvature)
        return _Stages(before, trailed(own.further, before.level, step, self.further))

    def passed(self, own: _Stages, motion: Motion, friction: Scalar) -> Scalar:
        return own.further.level
