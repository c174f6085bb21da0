"""Periodic states: against closed forms, against the marched reference, and where there is none."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from jaxstick.laps import Laps
from jaxstick.parts.contact import PaperContact, SmoothContact
from jaxstick.parts.friction import AbstractFriction, ExponentialFriction
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.pursuit import TOLERANCE
from jaxstick.sensitivity import multipliers
from jaxstick.steady import periodic_states
from jaxstick.steady_outcome import steady_outcomes
from tests.jaxstick.twin import twin
from tests.reference import closed_forms, loaded, rig1987
from tests.reference.drive import SineDrive
from tests.reference.oscillator import Oscillator as ReferenceRig


def of_1987(*ratios: float) -> Laps:
    return Laps.of([twin(rig1987.rig(), rig1987.drive(ratio)) for ratio in ratios])


def test_without_friction_state_and_multipliers_have_closed_forms() -> None:
    """The step is a 200th of the contact's ring, the error of the phase then 1e-5."""
    ratios = [0.05, 0.33, 0.95, 1.7]
    rig = replace(rig1987.rig(), A=0.0, C=0.0, D=0.0, drive_damping=2.0)
    laps = Laps.of([twin(rig, rig1987.drive(ratio)) for ratio in ratios])
    states = periodic_states(laps)
    outcomes = steady_outcomes(laps, states)
    found = multipliers(laps, states)
    assert states.period.tolist() == [1] * 4
    for lane, ratio in enumerate(ratios):
        omega = 2 * math.pi * rig1987.drive(ratio).frequency
        response = complex(rig.stiffness, omega * rig.drive_damping) * rig1987.BASE_AMPLITUDE
        response /= complex(rig.stiffness - rig.mass * omega**2, omega * rig.damping)
        assert outcomes.amplitude[lane] == pytest.approx(abs(response), rel=5e-5)
        assert outcomes.harmonics[lane, 0] == pytest.approx(abs(response), rel=5e-5)
        assert outcomes.phases[lane, 0] == pytest.approx(np.angle(response), abs=5e-5)
        assert outcomes.harmonics[lane, 1:].max() < 1e-7 * abs(response)
        decay = rig.damping / (2 * rig.mass)
        swing = math.sqrt(rig.stiffness / rig.mass - decay**2)
        expected = np.exp((-decay + 1j * swing) * laps.periods[lane])
        pair = sorted(found[lane, :2], key=lambda value: value.imag)
        assert pair == pytest.approx(sorted([expected, expected.conjugate()], key=lambda z: z.imag), abs=2e-4)
        assert np.abs(found[lane, 2:]).max() < 1e-6
        spent = math.pi * omega * ((rig.damping - 2.0) * abs(response) ** 2)
        spent += math.pi * omega * 2.0 * abs(response - rig1987.BASE_AMPLITUDE) ** 2
        assert outcomes.viscous_work[lane] == pytest.approx(spent, rel=1e-4)
        assert abs(outcomes.friction_work[lane]) < 1e-6 * spent


@pytest.mark.parametrize(("zeta", "ratio"), [(0.03, 0.8), (0.1, 1.0), (0.05, 1.4)])
def test_den_hartog(zeta: float, ratio: float) -> None:
    """Coulomb and viscous friction under a force, no stops; two stiff contacts tell that of a rigid one."""
    damping = 2 * zeta * math.sqrt(rig1987.STIFFNESS * rig1987.MASS)
    drive = SineDrive(ratio * rig1987.NATURAL_FREQUENCY, force_amplitude=10.0)
    rigs = [
        ReferenceRig(rig1987.MASS, rig1987.STIFFNESS, damping, 0.0, 0.0, 3.0, 0.0, k1) for k1 in (1e7, 4e7)
    ]
    laps = Laps.of([twin(rig, drive) for rig in rigs])
    states = periodic_states(laps)
    soft, stiff = steady_outcomes(laps, states).amplitude
    expected = closed_forms.den_hartog_amplitude(
        rig1987.MASS, rig1987.STIFFNESS, damping, drive.frequency, 10.0, 3.0
    )
    assert states.period.tolist() == [1, 1]
    assert 2 * stiff - soft == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(("ratio", "cycles"), [(0.13, 12), (0.326, 70), (0.6, 25)])
def test_states_are_those_the_reference_is_marched_to(ratio: float, cycles: int) -> None:
    rig, drive = rig1987.rig(), rig1987.drive(ratio)
    samples = 64
    time = drive.period * np.concatenate([[0.0], cycles - 1 + np.arange(samples + 1) / samples])
    run = loaded.simulate(rig, drive, time)
    laps = of_1987(ratio)
    states = periodic_states(laps)
    outcomes = steady_outcomes(laps, states)
    assert states.period[0] == 1
    assert states.residual[0] < TOLERANCE
    assert np.ptp(run.x[1:]) / 2 == pytest.approx(outcomes.amplitude[0], rel=3e-3)
    section = np.interp(states.course.section[0], np.arange(samples + 1) / samples, run.x[1:])
    reach = 2 * outcomes.amplitude[0]
    assert abs(states.state[0, 0] - section) < 3e-3 * reach
    turns = 2 * math.pi * np.arange(samples) / samples
    for harmonic in (1, 3):
        parts = [2 * np.mean(run.x[1:-1] * part(harmonic * turns)) for part in (np.cos, np.sin)]
        assert math.hypot(*parts) == pytest.approx(outcomes.harmonics[0, harmonic - 1], abs=1e-4 * reach)


def test_every_state_closes_and_attracts() -> None:
    laps = of_1987(*np.linspace(0.04, 1.0, 41))
    states = periodic_states(laps)
    periodic = states.period > 0
    assert np.mean(periodic) > 0.9
    assert states.residual[periodic].max() < TOLERANCE
    exact = np.abs(multipliers(laps, states)[:, 0])
    assert exact[periodic].max() < 1
    assert np.isnan(exact[~periodic]).all()
    assert np.quantile(np.abs(exact - np.abs(states.multipliers[:, 0]))[periodic], 0.9) < 0.1


def test_what_goes_in_through_the_base_is_dissipated() -> None:
    laps = of_1987(0.07, 0.3, 0.7)
    outcomes = steady_outcomes(laps, periodic_states(laps))
    taken = math.pi * rig1987.STIFFNESS * rig1987.BASE_AMPLITUDE * outcomes.harmonics[:, 0]
    taken *= -np.sin(outcomes.phases[:, 0])
    assert outcomes.friction_work + outcomes.viscous_work == pytest.approx(taken, rel=2e-5)


def test_a_period_of_two_cycles_is_found_and_named() -> None:
    """Marching at this ratio has settled on two cycles, 3 permille of the stroke apart, after 50."""
    states = periodic_states(of_1987(0.45864661654135336))
    assert states.period.tolist() == [2]
    assert states.course.cycles.tolist() == [2.0]
    assert states.residual[0] < TOLERANCE


def test_what_never_closes_is_not_called_periodic() -> None:
    """The contact in the paper's words restarts from zero force at every arrest and is chaotic when slow."""
    drive = rig1987.drive(0.09)
    laps = Laps.of([twin(rig1987.rig(), drive, PaperContact)])
    states = periodic_states(laps)
    assert states.period.tolist() == [0]
    assert states.residual[0] > 1e-5
    assert np.isnan(states.multipliers).all()
    assert states.course.cycles.tolist() == [8.0]
    assert steady_outcomes(laps, states).amplitude[0] == pytest.approx(rig1987.BASE_AMPLITUDE, rel=0.4)


def test_a_mass_that_never_breaks_away_swings_on_its_contact() -> None:
    drive = SineDrive(0.5 * rig1987.NATURAL_FREQUENCY, 1e-3)
    rig = rig1987.rig()
    laps = Laps.of([twin(rig, drive)])
    states = periodic_states(laps)
    outcomes = steady_outcomes(laps, states)
    omega = 2 * math.pi * drive.frequency
    response = rig.stiffness * 1e-3
    response /= abs(complex(rig.stiffness + rig.k1 - rig.mass * omega**2, omega * rig.damping))
    assert states.period.tolist() == [1]
    assert outcomes.amplitude[0] == pytest.approx(response, rel=1e-5)
    assert outcomes.stops.tolist() == [0.0]


def test_the_smooth_contact_and_the_loaded_one_agree() -> None:
    drives = [rig1987.drive(ratio) for ratio in (0.25, 0.75)]
    amplitude = [
        steady_outcomes(laps, periodic_states(laps)).amplitude
        for laps in (
            Laps.of([twin(rig1987.rig(), drive, contact) for drive in drives])
            for contact in (SmoothContact, type(twin(rig1987.rig(), drives[0]).contact))
        )
    ]
    assert amplitude[0] == pytest.approx(amplitude[1], rel=5e-3)


class Lagging(AbstractFriction):
    """A law whose limit follows the inner one's with a lag of `time` [s]: a state of its own."""

    inner: AbstractFriction
    time: Scalar

    def initial(self, motion: Motion) -> Any:
        return self.inner.limit(None, motion._replace(slide_rate=0.0))

    def advance(self, state: Any, motion: Motion, step: Scalar) -> Any:
        return state + (self.inner.limit(None, motion) - state) * step / (self.time + step)

    def limit(self, state: Any, motion: Motion) -> Scalar:
        return state

    def viscous(self, state: Any, motion: Motion) -> Scalar:
        return self.inner.viscous(None, motion)


def test_private_states_of_the_parts_close_too() -> None:
    oscillators = [twin(rig1987.rig(), rig1987.drive(ratio)) for ratio in (0.3, 0.8)]
    laps = Laps.of([replace(o, friction=Lagging(o.friction, 0.02)) for o in oscillators])
    states = periodic_states(laps)
    assert isinstance(oscillators[0].friction, ExponentialFriction)
    assert states.period.tolist() == [1, 1]
    end = laps.traverse(states.course, states.state)
    gap = np.abs(end.end - states.state) / (end.greatest - end.least)
    assert gap.max() < 1e-6
    exact = np.abs(multipliers(laps, states)[:, 0])
    assert (exact > 1e-6).all()
    assert (exact < 1).all()
