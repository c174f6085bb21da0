"""Forward simulation against closed-form answers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from jaxstick.oscillator import Start
from jaxstick.simulate import simulate
from tests.jaxstick.twin import twin
from tests.reference import closed_forms, rig1987
from tests.reference.drive import SineDrive
from tests.reference.oscillator import Oscillator

STIFF = 1e7
"""A contact [N/m] whose deflection under 10 N is 1 um."""


def _coulomb(friction: float, damping: float, stiffness: float = rig1987.STIFFNESS) -> Oscillator:
    return Oscillator(rig1987.MASS, stiffness, damping, 0.0, 0.0, friction, 0.0, STIFF)


def _rigid_limit(answer: Callable[[Oscillator], np.ndarray | float], rig: Oscillator) -> np.ndarray:
    """The answer for a rigid contact: from k1 and 4 k1, for each reversal takes a time like 1/sqrt(k1)."""
    soft, stiff = (np.asarray(answer(replace(rig, k1=k1))) for k1 in (STIFF, 4 * STIFF))
    return 2 * stiff - soft


@pytest.mark.parametrize("ratio", [0.046, 0.326, 0.95, 2.0])
def test_linear_limit(ratio: float) -> None:
    """Without friction a cycle on the steady orbit stays on it to 1e-8 of the amplitude (step 2.5e-6 s)."""
    rig = replace(rig1987.rig(), A=0.0, C=0.0, D=0.0)
    drive = rig1987.drive(ratio)
    omega = 2 * math.pi * drive.frequency
    response = rig.stiffness * drive.base_amplitude
    response /= complex(rig.stiffness - rig.mass * omega**2, rig.damping * omega)
    samples = 201
    interval = drive.period / (samples - 1)
    orbit = np.imag(response * np.exp(1j * omega * interval * np.arange(samples)))
    start = Start(orbit[0], float(np.imag(1j * omega * response)), 0.0)
    run = simulate(
        twin(rig, drive),
        samples=samples,
        interval=interval,
        start=start,
        steps_per_sample=math.ceil(interval / 2.5e-6),
    )
    assert np.abs(np.asarray(run.x) - orbit).max() < 1e-8 * abs(response)


def test_coulomb_decay() -> None:
    """The amplitude of free motion falls by 4 F/K a cycle, and the mass rests where the spring lets it."""
    friction, start = 4.0, 0.05
    rig = _coulomb(friction, 0.0)
    turning = closed_forms.coulomb_decay(rig.stiffness, friction, start)
    half = math.pi * math.sqrt(rig.mass / rig.stiffness)

    def rests(rig: Oscillator) -> np.ndarray:
        run = simulate(
            twin(rig, SineDrive(1.0)),
            samples=len(turning),
            interval=half,
            start=Start(start, 0.0, friction),
            steps_per_sample=20000,
        )
        return np.asarray(run.x)

    x = _rigid_limit(rests, rig)
    assert len(x) > 5
    assert x == pytest.approx(turning, abs=2e-6)
    assert x[2] - x[0] == pytest.approx(-4 * friction / rig.stiffness, abs=2e-6)


def _steady_amplitude(rig: Oscillator, drive: SineDrive, cycles: int) -> float:
    samples = 400
    run = simulate(
        twin(rig, drive),
        samples=samples * cycles + 1,
        interval=drive.period / samples,
        steps_per_sample=max(1, math.ceil(drive.period / samples / 2e-5)),
    )
    last = np.asarray(run.x)[-samples - 1 :]
    return float(np.ptp(last) / 2)


@pytest.mark.parametrize(("zeta", "ratio"), [(0.03, 0.8), (0.1, 1.0), (0.05, 1.4)])
def test_den_hartog(zeta: float, ratio: float) -> None:
    """Force-driven, Coulomb and viscous friction, no stops."""
    rig = _coulomb(3.0, 2 * zeta * math.sqrt(rig1987.STIFFNESS * rig1987.MASS))
    drive = SineDrive(ratio * rig1987.NATURAL_FREQUENCY, force_amplitude=10.0)
    given = (rig.mass, rig.stiffness, rig.damping, drive.frequency, 10.0, 3.0)
    assert closed_forms.den_hartog_moves(*given)
    expected = closed_forms.den_hartog_amplitude(*given)
    amplitude = _rigid_limit(lambda rig: _steady_amplitude(rig, drive, 60), rig)
    assert amplitude == pytest.approx(expected, rel=2e-4)


def test_hundal() -> None:
    """Base-driven through spring and damper, Coulomb friction against the ground, no stops."""
    rig = replace(_coulomb(3.0, 4.53), drive_damping=4.53)
    drive = SineDrive(0.9 * rig1987.NATURAL_FREQUENCY, 8e-3)
    expected = closed_forms.hundal_amplitude(
        rig.mass, rig.stiffness, rig.damping, drive.frequency, drive.base_amplitude, 3.0
    )
    amplitude = _rigid_limit(lambda rig: _steady_amplitude(rig, drive, 60), rig)
    assert amplitude == pytest.approx(expected, rel=2e-4)


def test_mass_without_spring_stops_from_the_tou_schultheiss_limit_on() -> None:
    """Under P sin the mass rests within a cycle from F/P = 1/sqrt(1 + pi^2/4) = 0.537 on, not before.

    Rest is a speed below a thousandth of the top speed for over 1 % of the cycle. The paper quotes 2/pi.
    """
    force, samples, cycles = 10.0, 1000, 15
    shares = np.arange(0.51, 0.571, 0.01)
    resting = []
    for share in shares:
        rig = replace(_coulomb(share * force, 0.0, 0.0), drive_stiffness=0.0, k1=1e9)
        drive = SineDrive(2.0, force_amplitude=force)
        run = simulate(
            twin(rig, drive), samples=samples * cycles, interval=drive.period / samples, steps_per_sample=40
        )
        speed = np.abs(np.asarray(run.v)[-samples:])
        resting.append(np.mean(speed < 1e-3 * speed.max()))
    first = shares[np.argmax(np.array(resting) > 0.01)]
    assert max(resting) > 0.04
    assert closed_forms.TOU_SCHULTHEISS_LIMIT < first < closed_forms.TOU_SCHULTHEISS_LIMIT + 0.015
