"""Forward accuracy: against the event-driven references with the same contact, and order of convergence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from jaxstick.parts.contact import AbstractContact, LoadedContact, PaperContact
from tests.jaxstick.twin import simulate_twin
from tests.reference import loaded, paper, rig1987
from tests.reference.drive import SineDrive
from tests.reference.oscillator import Oscillator

SOFT = replace(rig1987.rig(), A=3.0, C=4.0, B=80.0, D=2.0, k1=2e4)
CASES: dict[str, tuple[Oscillator, SineDrive]] = {
    "paper's rig, two stops": (rig1987.rig(), rig1987.drive(0.326)),
    "soft contact": (SOFT, SineDrive(2.0, 0.01, 0.4)),
    "no weakening": (replace(rig1987.rig(), A=0.0, C=7.0), rig1987.drive(0.326)),
    "strong viscous slope": (replace(rig1987.rig(), D=20.0), rig1987.drive(0.326)),
    "rubbing on the base": (replace(SOFT, friction_against="base", drive_damping=3.0), SineDrive(1.5, 0.01)),
    "no springs, driven by a force": (
        replace(rig1987.rig(), stiffness=0.0, drive_stiffness=0.0, D=5.0),
        SineDrive(2.0, force_amplitude=15.0),
    ),
}
REFERENCES = {LoadedContact: loaded.simulate, PaperContact: paper.simulate}
INTERVAL = 1e-3
RESTS_ON_THE_BASE = ("rubbing on the base", PaperContact)
"""The paper's contact says nothing of a mass that rests while its guide moves at the start."""


def _error(case: str, contact: type[AbstractContact], steps: int, cycles: float = 2.2) -> float:
    """Largest error of the displacement over the stroke."""
    rig, drive = CASES[case]
    times = INTERVAL * np.arange(int(cycles / drive.frequency / INTERVAL))
    exact = REFERENCES[contact](rig, drive, times)
    assert exact.count("stick", times[0], times[-1]) >= 2
    ours = simulate_twin(rig, drive, times, steps, contact)
    return float(np.abs(ours.x - exact.x).max() / np.ptp(exact.x))


@pytest.mark.parametrize("contact", list(REFERENCES))
@pytest.mark.parametrize("case", list(CASES))
def test_displacement_is_right_to_a_millionth_of_the_stroke(
    case: str, contact: type[AbstractContact]
) -> None:
    """At a step of 1/32 ms; the two-stop motion of the paper's rig reaches it at 1/16 ms."""
    if (case, contact) == RESTS_ON_THE_BASE:
        pytest.skip("no common start")
    assert _error(case, contact, 32) < 1e-6
    if case == "paper's rig, two stops":
        assert _error(case, contact, 16) < 1e-6


@pytest.mark.parametrize("contact", list(REFERENCES))
def test_second_order_through_stick_and_slip(contact: type[AbstractContact]) -> None:
    """The error falls with the square of the step, events included."""
    steps = np.array([2, 4, 8, 16, 32, 64])
    errors = [_error("paper's rig, two stops", contact, int(n)) for n in steps]
    slope = np.polyfit(np.log(1.0 / steps), np.log(errors), 1)[0]
    assert 1.8 < slope < 2.6


def test_friction_force_is_right_along_ten_stops() -> None:
    """Over a cycle of the slowest of the paper's five ratios: F within 1e-4 N rms of 7.5 N, x within 1e-6."""
    rig, drive = rig1987.rig(), rig1987.drive(0.046)
    times = INTERVAL * np.arange(int(1.0 / drive.frequency / INTERVAL))
    exact = loaded.simulate(rig, drive, times)
    ours = simulate_twin(rig, drive, times, 128)
    assert np.abs(ours.x - exact.x).max() < 1e-6 * np.ptp(exact.x)
    assert np.sqrt(np.mean((ours.friction - exact.F) ** 2)) < 1e-4


def test_a_stiff_contact_needs_no_smaller_step() -> None:
    """k1 forty thousand times above what the step resolves: stable, and within 1 % of the rigid limit."""
    drive = rig1987.drive(0.326)
    times = 2e-3 * np.arange(600)
    stiff = simulate_twin(rig1987.rig(k1=1e12), drive, times, 4)
    exact = loaded.simulate(rig1987.rig(k1=1e8), drive, times)
    assert np.abs(stiff.x - exact.x).max() < 1e-2 * np.ptp(exact.x)


def test_energy_balance() -> None:
    """Work of drive, damper and friction equals the change of kinetic and elastic energy."""
    rig, drive = SOFT, SineDrive(1.5, 0.01, 0.4)
    times = 1e-4 * np.arange(15001)
    run = simulate_twin(rig, drive, times, 4)
    y = np.array([drive.position(t) for t in times])
    power = (rig.stiffness * y - rig.damping * run.v + run.friction) * run.v
    work = np.sum(0.5 * (power[1:] + power[:-1])) * 1e-4
    energy = 0.5 * rig.mass * run.v**2 + 0.5 * rig.stiffness * run.x**2
    assert np.abs(np.diff(energy)).sum() > 0.1
    assert work == pytest.approx(energy[-1] - energy[0], abs=2e-6)
