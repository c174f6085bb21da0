"""What periodic states amount to: amplitude, stops, harmonics, work, lane by lane."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxstick.laps import Course, Laps, Real
from jaxstick.outcome import outcome
from jaxstick.return_map import BLOCK
from jaxstick.steady import PeriodicStates

SAMPLES_PER_NATURAL_PERIOD = 80
SAMPLES_PER_CYCLE = 64
SAMPLES_WITHOUT_SPRINGS = 1000


@dataclass(frozen=True, eq=False)
class SteadyOutcomes:
    """One entry a lane, all counted per cycle of the drive; over several cycles they are averages.

    amplitude: half of peak to peak [m]; harmonics, phases (lanes, 9): amplitudes [m] and phases [rad] of
    x = sum X_k sin(k p + phi_k), p the phase of the drive; stops and stick_fraction as
    `jaxstick.outcome.outcome` defines them; friction_work, viscous_work: dissipated by friction and by the
    rig's linear dampers [J].
    """

    amplitude: Real
    harmonics: Real
    phases: Real
    stops: Real
    stick_fraction: Real
    friction_work: Real
    viscous_work: Real


def steady_outcomes(laps: Laps, states: PeriodicStates) -> SteadyOutcomes:
    """What the motion of every lane amounts to, over one period of it, or over the cycles last looked at."""
    natural = laps.natural_frequency()

    def stops(course: Course, displacement: Real) -> Real:
        found = [
            _stops(
                row[: round(steps * cycles / BLOCK)], float(laps.periods[lane]), cycles, float(natural[lane])
            )
            for row, lane, steps, cycles in zip(
                displacement, course.lane, course.steps, course.cycles, strict=True
            )
        ]
        return np.array(found)

    _, amounts, counted = laps.record(states.course, states.state, stops)
    return SteadyOutcomes(
        amplitude=amounts.amplitude,
        harmonics=np.hypot(amounts.cosines, amounts.sines),
        phases=np.arctan2(amounts.cosines, amounts.sines),
        stops=counted[:, 0],
        stick_fraction=counted[:, 1],
        friction_work=amounts.friction_work,
        viscous_work=amounts.viscous_work,
    )


def _stops(
    displacement: NDArray[np.float64], period: float, cycles: float, natural: float
) -> tuple[float, float]:
    """Stops a cycle and stick fraction of a closed lap, sampled anew at as many points as they ask for."""
    per_cycle = SAMPLES_PER_NATURAL_PERIOD * natural * period if natural else SAMPLES_WITHOUT_SPRINGS
    samples = round(cycles) * max(SAMPLES_PER_CYCLE, math.ceil(per_cycle))
    places = np.arange(samples) * (len(displacement) / samples)
    sampled = np.interp(places, np.arange(len(displacement)), displacement, period=len(displacement))
    found = outcome(
        sampled, interval=period * cycles / samples, frequency=1 / period, natural_frequency=natural
    )
    return found.stops, found.stick_fraction
