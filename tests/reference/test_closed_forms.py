"""The rigid reference model against closed-form solutions."""

from math import cos, pi, sqrt

import numpy as np
import pytest

from tests.reference import closed_forms, rig1987, rigid
from tests.reference.drive import SineDrive, no_drive
from tests.reference.march import Run
from tests.reference.oscillator import Oscillator


def last_cycle(rig: Oscillator, drive: SineDrive, cycles: int) -> Run:
    """The last of `cycles` cycles, finely sampled; the first sample is the start of the simulation."""
    T = drive.period
    times = np.concatenate([[0.0], np.linspace((cycles - 1) * T, cycles * T, 2001)])
    return rigid.simulate(rig, drive, times)


def amplitude(run: Run) -> float:
    """Half the peak-to-peak travel [m] after the first sample."""
    return float(np.ptp(run.x[1:])) / 2.0


def stops(run: Run) -> int:
    """Stick intervals beginning in the last cycle."""
    return run.count("stick", run.time[1], run.time[-1])


def coulomb(friction: float, damping: float = 0.0, stiffness: float = rig1987.STIFFNESS) -> Oscillator:
    """The 1987 mass with constant sliding friction."""
    return Oscillator(rig1987.MASS, stiffness, damping, 0.0, 0.0, friction, 0.0)


@pytest.mark.parametrize("ratio", [0.4, 0.95, 1.7])
def test_linear_steady_state(ratio: float) -> None:
    frequency = ratio * rig1987.NATURAL_FREQUENCY
    rig = Oscillator(2.38, 1986.0, 30.0, 0.0, 0.0, 0.0, 0.0, drive_stiffness=993.0, drive_damping=11.0)
    for drive, load in (
        (SineDrive(frequency, base_amplitude=0.01), closed_forms.base_load(993.0, 11.0, frequency, 0.01)),
        (SineDrive(frequency, force_amplitude=3.0, force_phase=0.7), 3.0),
    ):
        expected = closed_forms.linear_amplitude(2.38, 1986.0, 30.0, frequency, load)
        assert amplitude(last_cycle(rig, drive, 25)) == pytest.approx(expected, rel=3e-6)


def test_base_and_force_add_by_phase() -> None:
    """An applied force equal and opposite to the spring's pull on the base leaves the mass at rest."""
    f, Y, k_d, c_d = 1.3, 0.01, 1500.0, 4.0
    omega = 2.0 * pi * f
    rig = Oscillator(2.38, 1986.0, 30.0, 0.0, 0.0, 0.0, 0.0, drive_stiffness=k_d, drive_damping=c_d)
    force = Y * np.hypot(k_d, c_d * omega)
    phase = float(np.arctan2(c_d * omega, k_d)) + 0.3
    still = SineDrive(f, Y, 0.3, force_amplitude=-float(force), force_phase=phase)
    run = rigid.simulate(rig, still, np.linspace(0.0, 1.0, 50))
    assert np.abs(run.x).max() < 1e-15


def test_coulomb_decay() -> None:
    friction, start = 1.1, 0.0123
    half = 0.5 / rig1987.NATURAL_FREQUENCY
    expected = closed_forms.coulomb_decay(rig1987.STIFFNESS, friction, start)
    assert len(expected) == 12
    run = rigid.simulate(coulomb(friction), no_drive(), half * np.arange(len(expected) + 2), start)
    np.testing.assert_allclose(run.x[: len(expected)], expected, atol=1e-12)
    np.testing.assert_allclose(run.x[len(expected) :], expected[-1], atol=1e-12)
    assert [kind for _, kind in run.events].count("stick") == 1
    assert run.events[-1][1] == "stick"


@pytest.mark.parametrize(
    ("zeta", "beta", "share", "moves"),
    [
        (0.0, 0.4, 0.2, False),
        (0.0, 0.6, 0.5, True),
        (0.0, 0.6, 0.7, False),
        (0.0, 0.8, 0.8, True),
        (0.0, 1.2, 0.7, True),
        (0.05, 0.4, 0.2, False),
        (0.05, 0.6, 0.2, True),
        (0.05, 0.6, 0.5, False),
        (0.05, 1.2, 0.5, True),
        (0.05, 1.2, 0.7, False),
        (0.2, 0.8, 0.5, True),
        (0.2, 0.8, 0.7, False),
        (0.2, 2.0, 0.5, True),
        (0.2, 2.0, 0.7, False),
    ],
)
def test_den_hartog(zeta: float, beta: float, share: float, moves: bool) -> None:
    m, K, P = rig1987.MASS, rig1987.STIFFNESS, 10.0
    c, f, F = 2.0 * zeta * sqrt(K * m), beta * rig1987.NATURAL_FREQUENCY, share * 10.0
    assert closed_forms.den_hartog_moves(m, K, c, f, P, F) is moves
    run = last_cycle(coulomb(F, c), SineDrive(f, force_amplitude=P), 60 if zeta else 400)
    assert stops(run) == (0 if moves else 2)
    if moves:
        expected = closed_forms.den_hartog_amplitude(m, K, c, f, P, F)
        assert amplitude(run) == pytest.approx(expected, rel=2e-3 if zeta == 0.0 else 2e-6)


def test_den_hartog_limit_of_motion_without_stops() -> None:
    """The friction at which stops appear, found by bisection on the closed form, is the simulation's."""
    m, K, c, f, P = rig1987.MASS, rig1987.STIFFNESS, 15.0, 0.7 * rig1987.NATURAL_FREQUENCY, 10.0
    low, high = 0.1, 9.9
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if closed_forms.den_hartog_moves(m, K, c, f, P, middle) else (low, middle)
    drive = SineDrive(f, force_amplitude=P)
    assert stops(last_cycle(coulomb(low - 0.01, c), drive, 60)) == 0
    assert stops(last_cycle(coulomb(high + 0.01, c), drive, 60)) == 2


def test_hundal() -> None:
    m, K, c, f, Y, F = rig1987.MASS, rig1987.STIFFNESS, 12.0, 1.1 * rig1987.NATURAL_FREQUENCY, 8e-3, 6.0
    rig = Oscillator(m, K, c, 0.0, 0.0, F, 0.0, drive_damping=c)
    run = last_cycle(rig, SineDrive(f, Y), 80)
    assert stops(run) == 0
    assert amplitude(run) == pytest.approx(closed_forms.hundal_amplitude(m, K, c, f, Y, F), rel=2e-6)


@pytest.mark.parametrize(("share", "expected_stops"), [(0.3, 0), (0.530, 0), (0.545, 2), (0.8, 2)])
def test_tou_schultheiss(share: float, expected_stops: int) -> None:
    assert pytest.approx(0.537, abs=5e-4) == closed_forms.TOU_SCHULTHEISS_LIMIT
    f, P = 3.0, 5.0
    run = last_cycle(coulomb(share * P, stiffness=0.0), SineDrive(f, force_amplitude=P), 300)
    assert stops(run) == expected_stops
    if not expected_stops:
        expected = closed_forms.tou_schultheiss_amplitude(rig1987.MASS, f, P, share * P)
        assert amplitude(run) == pytest.approx(expected, rel=1e-4)


def test_tou_schultheiss_phase_of_rest() -> None:
    """Where it stops, the mass leaves when the force reaches the friction: u = F."""
    f, P, share = 3.0, 5.0, 0.8
    drive = SineDrive(f, force_amplitude=P, force_phase=pi / 2.0)
    run = last_cycle(coulomb(share * P, stiffness=0.0), drive, 20)
    starts = [t for t, kind in run.events if kind == "slip+"][1:]
    np.testing.assert_allclose([P * cos(2.0 * pi * f * t) for t in starts], share * P, rtol=1e-9)


@pytest.mark.parametrize("dynamic_ratio", [0.85, 0.90])
def test_stops_of_the_paper(dynamic_ratio: float) -> None:
    for ratio, expected in rig1987.STOPS.items():
        drive = rig1987.drive(ratio)
        run = rigid.simulate(rig1987.rig(dynamic_ratio), drive, np.array([0.0, 8.0 * drive.period]))
        per_cycle = [run.count("stick", n * drive.period, (n + 1) * drive.period) for n in (5, 6, 7)]
        assert per_cycle == [expected] * 3


def test_stops_of_the_paper_need_the_right_dynamic_friction() -> None:
    drive = rig1987.drive(0.071)
    run = rigid.simulate(rig1987.rig(0.80), drive, np.array([0.0, 8.0 * drive.period]))
    assert run.count("stick", 6.0 * drive.period, 7.0 * drive.period) == 6
