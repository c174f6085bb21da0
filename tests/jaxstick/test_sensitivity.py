"""Derivatives through the periodic state against central differences of states settled to rounding."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from jaxstick.cycle_sums import Amounts
from jaxstick.laps import Laps, Real
from jaxstick.parameter import find
from jaxstick.parameter import replace as with_values
from jaxstick.sensitivity import Direction, Sensitivity, sensitivities
from jaxstick.steady import PeriodicStates, periodic_states
from tests.jaxstick.twin import twin
from tests.reference import rig1987

RATIOS = (0.35, 0.5, 0.7, 0.95)
SHARES = {
    "friction.A": (1e-5, 1e-6),
    "friction.B": (1e-5, 1e-6),
    "friction.C": (1e-6, 1e-7),
    "friction.D": (1e-2, 1e-3),
    "contact.k1": (1e-5, 1e-6),
    "rig.mass": (1e-6, 1e-7),
    "rig.damping": (1e-5, 1e-6),
    "drive.base_amplitude": (1e-6, 1e-7),
    "drive.frequency": (1e-6, 1e-7),
}
"""Changes of each parameter, in shares of itself: large ones take events across nodes of the grid, small ones
meet rounding."""
PARAMETERS = tuple(SHARES)


def settled(laps: Laps, states: PeriodicStates) -> Real:
    """The states marched on for as long as it takes to forget what the search left."""
    state = states.state
    for _ in range(60):
        state = laps.traverse(states.course, state).end
    return state


def amounts(laps: Laps, states: PeriodicStates) -> Amounts:
    return laps.record(states.course, states.state, lambda course, _: np.zeros(len(course)))[1]


@pytest.fixture(scope="module")
def rig() -> tuple[Laps, PeriodicStates, Sensitivity]:
    laps = Laps.of([twin(rig1987.rig(), rig1987.drive(ratio)) for ratio in RATIOS])
    states = periodic_states(laps)
    states = replace(states, state=settled(laps, states))
    return laps, states, sensitivities(laps, states, [direction(laps, name) for name in PARAMETERS])


def direction(laps: Laps, name: str) -> Direction:
    still = jax.tree.map(np.zeros_like, laps.oscillators)
    rates = with_values(still, {name: np.ones(len(laps))})
    return Direction(rates, -(laps.periods**2) * np.asarray(rates.drive.frequency))


def moved(laps: Laps, states: PeriodicStates, name: str, share: float) -> Amounts:
    """The amounts with a parameter changed by a share of itself, the grid of steps as it was."""
    value = find(laps.oscillators, name).of(laps.oscillators)
    other = with_values(laps.oscillators, {name: value * (1 + share)})
    there = Laps(other, 1 / np.asarray(other.drive.frequency))
    return amounts(there, replace(states, state=settled(there, states)))


@pytest.mark.parametrize("number", range(len(PARAMETERS)), ids=PARAMETERS)
def test_derivatives_of_all_amounts(number: int, rig: tuple[Laps, PeriodicStates, Sensitivity]) -> None:
    """To 1e-5 of the derivative, of the harmonics' to 1e-5 of the greatest among them."""
    laps, states, found = rig
    name = PARAMETERS[number]
    value = find(laps.oscillators, name).of(laps.oscillators)
    worst = []
    for share in SHARES[name]:
        up, down = (moved(laps, states, name, sign * share) for sign in (1, -1))
        gaps = []
        for more, less, all_exact in zip(up, down, found.amounts, strict=True):
            exact = all_exact[:, number]
            scale = np.reshape(2 * share * value, (-1, *[1] * (exact.ndim - 1)))
            slope = (more - less) / scale
            size = np.abs(slope).reshape(len(RATIOS), -1).max(axis=1).reshape(scale.shape)
            gaps.append(np.abs(exact - slope) / size)
        worst.append([gap.reshape(len(RATIOS), -1).max(axis=1) for gap in gaps])
    assert np.min(worst, axis=0).max() < 1e-5


def test_the_state_moves_as_the_implicit_function_theorem_says(
    rig: tuple[Laps, PeriodicStates, Sensitivity],
) -> None:
    laps, states, found = rig
    number = PARAMETERS.index("friction.C")
    shift = 1e-7 * rig1987.rig().C
    ends = []
    for sign in (1, -1):
        value = find(laps.oscillators, "friction.C").of(laps.oscillators)
        changed = with_values(laps.oscillators, {"friction.C": value + sign * shift})
        ends.append(settled(Laps(changed, laps.periods), states))
    slope = (ends[0] - ends[1]) / (2 * shift)
    assert found.state[:, number, :2] == pytest.approx(slope[:, :2], rel=1e-5, abs=1e-9)
