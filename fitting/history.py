"""Where mass and base have been before a segment of a run, and what the force channel showed: read off the
record, and beyond its beginning from the cycles that the motion repeats, or at rest where it repeats none."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fitting.cycle import samples_a_cycle
from fitting.signals import Signals
from jaxstick.parts.before import Before
from jaxstick.parts.track import Trace, Track

POINTS = 96
CYCLES = 4
"""So many cycles are looked back upon, or natural periods, where the excitation has none."""
STRETCH = 3.0
"""Points lie closer together near the start, by about exp(3)."""
GROWING = np.sinh(STRETCH * np.linspace(0, 1, POINTS)) / math.sinh(STRETCH)
REPEATED = 0.2
"""A motion repeats itself where it changes by less than this share of itself from cycle to cycle."""


@dataclasses.dataclass(frozen=True)
class History:
    """What a run shows, and what the time before it was like: how far it is looked back upon [s], and the
    cycle in which it repeats itself [s], None where it does not."""

    signal: Signals
    span: float
    cycle: float | None

    @classmethod
    def of(cls, signal: Signals, period: float | None) -> History:
        """That of a run; `period` is the natural one [s], None for a rig without springs."""
        run = signal.run
        samples = samples_a_cycle(run)
        cycle = None if samples is None else samples * run.interval
        length = float(run.time[-1] - run.time[0])
        span = CYCLES * (cycle or period or length / CYCLES)
        repeats = samples is not None and _repeats(run.displacement, samples)
        return cls(signal, span, cycle if repeats else None)

    def before(self, sample: int) -> Before:
        """What is known of the time before a sample."""
        signal, since = self.signal, self._since_slid(sample)
        return Before(
            rest=signal.rest[since],
            slid=signal.slid[since],
            impulse=signal.impulse[sample],
            impulse_sum=signal.impulse_sum[sample],
            recorded=signal.recorded[sample],
            shown=self.shown(sample),
            track=self.track(sample),
        )

    def track(self, sample: int) -> Track:
        """The displacements of mass and base before a sample."""
        run, lags = self.signal.run, self.span * GROWING
        times = self._within(run.time[sample] - lags)
        return Track(lags, *(np.interp(times, run.time, x) for x in (run.displacement, self.signal.base)))

    def shown(self, sample: int) -> Trace:
        """What the force channel showed before a sample [N], at first one interval apart; nothing but zero
        without that channel."""
        run = self.signal.run
        lags = run.interval / GROWING[1] * GROWING
        if run.friction is None:
            return Trace(lags, np.zeros(POINTS))
        return Trace(lags, np.interp(self._within(run.time[sample] - lags), run.time, run.friction))

    def _since_slid(self, sample: int) -> int:
        """The sample, or where the mass has not slid yet in the run, the same one of the first cycle before
        which it has: what rests at the beginning of a record has come to rest before it."""
        if self.cycle is None or self.signal.slid[sample] != 0:
            return sample
        last = len(self.signal.slid) - 1
        later = np.arange(sample, last, self.cycle / self.signal.run.interval).round().astype(int)
        known = later[self.signal.slid[later] != 0]
        return int(known[0]) if len(known) else sample

    def _within(self, times: np.ndarray) -> np.ndarray:
        """The times, those before the run moved on by whole cycles to where the motion was the same."""
        if self.cycle is None:
            return times
        cycles = np.ceil((self.signal.run.time[0] - times) / self.cycle - 1e-9)
        return times + self.cycle * np.maximum(cycles, 0)


def _repeats(displacement: np.ndarray, cycle: float) -> bool:
    """Whether the first cycle of a motion comes again, as far as the record goes; it holds at least one."""
    if len(displacement) < cycle:
        return False
    later = np.arange(math.ceil(cycle), min(len(displacement), math.floor(2 * cycle)))
    change = displacement[later] - np.interp(later - cycle, np.arange(len(displacement)), displacement)
    changed = np.std(change) + abs(np.mean(change)) if len(later) else 0.0
    return bool(changed < REPEATED * np.std(displacement))
