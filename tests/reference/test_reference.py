"""The reference models against each other, against brute force, and against the laws they must keep."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, inf, pi, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.reference import brute_force, loaded, paper, rig1987, rigid
from tests.reference.drive import GivenDrive, SineDrive, no_drive
from tests.reference.march import Run
from tests.reference.oscillator import Oscillator

MODELS: dict[str, Callable[..., Run]] = {
    "rigid": rigid.simulate,
    "loaded": loaded.simulate,
    "paper": paper.simulate,
}
SOFT = replace(rig1987.rig(), A=3.0, C=4.0, B=80.0, D=2.0, k1=2e4)
"""A soft contact: long sticks, a spring that outlasts the arrest."""
WEAK = replace(SOFT, A=5.0, B=150.0, C=2.0)
"""Strong weakening: the spring unloads while it carries more than g(|w|)."""
CASES = {
    "paper's rig": (rig1987.rig(), rig1987.drive(0.326)),
    "soft": (SOFT, SineDrive(2.0, 0.01, 0.4)),
    "weak": (WEAK, SineDrive(1.5, 0.01, 0.4)),
}


@pytest.mark.parametrize(("contact", "gap"), [("rigid", 1e-9), ("loaded", 2e-8), ("paper", 3e-6)])
@pytest.mark.parametrize("case", list(CASES))
def test_brute_force(contact: str, gap: float, case: str) -> None:
    """Traces with steps of 8 and 4 us, extrapolated to step zero; the jumps of `paper` spoil the order."""
    rig, drive = CASES[case]
    coarse, fine = (h * np.arange(n) for h, n in ((8e-6, 100_001), (4e-6, 200_001)))
    naive = 2.0 * brute_force.trace(rig, drive, contact, 0.002, 0.05, fine)[::500]
    naive -= brute_force.trace(rig, drive, contact, 0.002, 0.05, coarse)[::250]
    run = MODELS[contact](rig, drive, fine[::500], 0.002, 0.05)
    assert len(run.events) > 4
    np.testing.assert_allclose(run.x, naive, atol=gap)


@pytest.mark.parametrize("contact", list(MODELS))
@pytest.mark.parametrize("against", ["ground", "base"])
def test_energy_balance(contact: str, against: str) -> None:
    """Work of drive, damper and friction equals the change of the mass's and spring's energy."""
    rig = replace(SOFT, friction_against=against, drive_damping=3.0)
    drive = SineDrive(1.5, 0.01, 0.4, force_amplitude=3.0)
    events = [t for t, _ in MODELS[contact](rig, drive, np.array([0.0, 1.0]), 0.002, 0.05).events[1:]]
    sides = [t + side for t in events for side in (-1e-9, 1e-9)]
    times = np.unique([*np.linspace(0.0, 1.0, 40001), *sides])
    run = MODELS[contact](rig, drive, times, 0.002, 0.05)
    y = np.array([drive.position(t) for t in times])
    y_rate = np.array([drive.velocity(t) for t in times])
    u = np.array([drive.force(t) for t in times])
    power = (rig.stiffness * y + 3.0 * y_rate + u - rig.damping * run.v + run.F) * run.v
    work = np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(times))
    energy = 0.5 * rig.mass * run.v**2 + 0.5 * rig.stiffness * run.x**2
    assert work == pytest.approx(energy[-1] - energy[0], abs=1e-7)
    assert np.abs(np.diff(energy)).sum() > 0.1


def test_loaded_tends_to_rigid() -> None:
    drive = rig1987.drive(0.326)
    times = np.linspace(0.0, 1.3 * drive.period, 200)
    stiff = rigid.simulate(rig1987.rig(), drive, times)
    gaps = [
        np.abs(loaded.simulate(rig1987.rig(k1=k1), drive, times).x - stiff.x).max() for k1 in (1e5, 1e6, 1e7)
    ]
    assert gaps[0] < 6e-4
    assert gaps[1] < 0.15 * gaps[0]
    assert gaps[2] < 0.15 * gaps[1]


@pytest.mark.parametrize("contact", list(MODELS))
def test_friction_against_the_base_is_friction_against_the_ground_seen_from_the_base(contact: str) -> None:
    """With q = x - y: m q'' + c q' + K q = (k_d - K) y + (c_d - c) y' - m y'' + F(q')."""
    drive = SineDrive(2.2, 0.012, 0.9)
    rig = replace(SOFT, drive_stiffness=700.0, drive_damping=1.0, friction_against="base")
    times = np.linspace(0.0, 1.0, 300)

    def from_the_base(t: float) -> float:
        y, y_rate, y_acceleration = drive.position(t), drive.velocity(t), drive.acceleration(t)
        return (700.0 - rig.stiffness) * y + (1.0 - rig.damping) * y_rate - rig.mass * y_acceleration

    seen = GivenDrive(drive.time_scale, u=from_the_base)
    y = np.array([drive.position(t) for t in times])
    run = MODELS[contact](rig, drive, times, y[0], drive.velocity(0.0))
    other = MODELS[contact](replace(rig, friction_against="ground"), seen, times, 0.0, 0.0)
    assert len(run.events) >= 6
    np.testing.assert_allclose(run.x - y, other.x, atol=2e-10)
    np.testing.assert_allclose(run.F, other.F, atol=1e-5)
    assert [k for _, k in run.events] == [k for _, k in other.events]


def test_loaded_keeps_its_law() -> None:
    rig, drive = CASES["weak"]
    times = np.linspace(0.0, 2.0, 100001)
    run = loaded.simulate(rig, drive, times)
    limit = rig.A * np.exp(-rig.B * np.abs(run.v)) + rig.C
    load = rig.k1 * np.abs(run.z)
    assert load.max() <= rig.static_friction + 1e-9
    loading = run.v * run.z > 0.0
    assert (load - limit)[loading].max() < 1e-6
    assert (load - limit)[~loading].max() > 0.05
    mode = np.searchsorted([t for t, _ in run.events], times, "right") - 1
    slipping = np.array([kind != "stick" for _, kind in run.events])[mode]
    assert 0.2 < slipping.mean() < 0.8
    np.testing.assert_allclose(load[slipping], limit[slipping], atol=1e-9)
    sliding_force = -np.sign(run.v) * (limit + rig.D * np.abs(run.v))
    np.testing.assert_allclose(run.F[slipping], sliding_force[slipping], atol=1e-9)
    np.testing.assert_allclose(run.F[~slipping], -rig.k1 * run.z[~slipping], atol=1e-9)
    same_stick = ~slipping[1:] & (mode[1:] == mode[:-1])
    np.testing.assert_allclose(np.diff(run.z)[same_stick], np.diff(run.x)[same_stick], atol=1e-12)
    speed = np.maximum(np.abs(run.v[1:]), np.abs(run.v[:-1]))
    rise = np.sign(run.z[1:]) * np.diff(run.z) - speed * np.diff(times)
    assert rise.max() < 1e-9


def test_loaded_leaves_slip_before_the_arrest_where_the_limit_rises_too_fast() -> None:
    drive = SineDrive(1.5, 0.01, 0.4)
    for rig, early in ((SOFT, True), (replace(SOFT, A=0.0), False)):
        run = loaded.simulate(rig, drive, np.array([0.0, 3.0]))
        ends = [t for t, kind in run.events if kind == "stick" and t > 0.0]
        v = loaded.simulate(rig, drive, np.array([0.0, *ends])).v[1:]
        assert len(ends) > 3
        assert np.all(np.abs(v) > 1e-3) if early else np.all(np.abs(v) < 1e-9)


def test_paper_restarts_the_spring_at_each_arrest() -> None:
    rig, drive = SOFT, SineDrive(1.5, 0.01, 0.4)
    first = paper.simulate(rig, drive, np.array([0.0, 2.0]))
    arrests = [t for t, kind in first.events if kind == "stick" and t > 0.0]
    breakaways = [t for t, kind in first.events if kind != "stick"]
    assert len(arrests) > 3
    at = paper.simulate(rig, drive, np.array([0.0, *(t + 1e-9 for t in arrests)]))
    assert np.abs(at.F[1:]).max() < 1e-4
    before = paper.simulate(rig, drive, np.array([0.0, *(t - 1e-9 for t in breakaways)]))
    np.testing.assert_allclose(np.abs(before.F[1:]), rig.static_friction, atol=1e-4)


@pytest.mark.parametrize("contact", ["rigid", "loaded"])
def test_tolerance(contact: str) -> None:
    """The accuracy the docstrings of other tests rely on: 10 pm and 1 uN over a cycle with ten stops."""
    drive = rig1987.drive(0.046)
    times = np.linspace(0.0, drive.period, 500)
    run = MODELS[contact](rig1987.rig(), drive, times)
    fine = MODELS[contact](rig1987.rig(), drive, times, tolerance=1e-13)
    assert np.abs(run.x - fine.x).max() < 1e-11
    assert np.abs(run.F - fine.F).max() < 1e-6


def test_one_mode_against_scipy() -> None:
    """A free slide that never stops: one smooth equation, with an extra force."""
    rig = replace(SOFT, extra_force=lambda t, x, v: -2e5 * x**3 - 0.3 * v * abs(v))
    drive = GivenDrive(0.1, y=lambda t: 0.02 * t, y_rate=lambda t: 0.02, u=lambda t: 30.0)

    def rate(t: float, state: np.ndarray) -> list[float]:
        x, v = state
        force = rig.stiffness * 0.02 * t + 30.0 - rig.stiffness * x - rig.damping * v
        force -= rig.A * np.exp(-rig.B * v) + rig.C + rig.D * v
        return [v, (force - 2e5 * x**3 - 0.3 * v * abs(v)) / rig.mass]

    times = np.linspace(0.0, 0.06, 30)
    known = solve_ivp(rate, (0.0, 0.06), [0.0, 0.3], "DOP853", times, rtol=1e-13, atol=1e-15)
    run = rigid.simulate(rig, drive, times, 0.0, 0.3)
    assert [kind for _, kind in run.events] == ["slip+"]
    np.testing.assert_allclose(run.x, known.y[0], atol=1e-12)
    np.testing.assert_allclose(run.v, known.y[1], atol=1e-10)


def test_given_drive_equals_sine_drive() -> None:
    sine = SineDrive(1.7, 0.01, 0.4, 2.0, 1.1)
    given = GivenDrive(sine.time_scale, sine.position, sine.velocity, sine.acceleration, sine.force)
    times = np.linspace(0.0, 1.2, 200)
    for simulate in MODELS.values():
        a, b = simulate(SOFT, sine, times), simulate(SOFT, given, times)
        np.testing.assert_allclose(a.x, b.x, atol=1e-10)


def test_breakpoints_are_met_exactly() -> None:
    """A force of 5 N, switched on and off, on a resting mass with 2 N of friction: two parabolas."""
    on, off, m = 0.0307, 0.1511, 2.0
    drive = GivenDrive(1.0, u=lambda t: 5.0 if on <= t < off else 0.0, breakpoints=(on, off))
    rig = Oscillator(m, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0)
    times = np.linspace(0.0, 0.4, 81)
    run = rigid.simulate(rig, drive, times)
    rest = off + 1.5 * (off - on)
    expected = 0.5 * 3.0 / m * np.clip(times - on, 0.0, off - on) ** 2
    coasting = np.clip(times, off, rest) - off
    expected += 3.0 / m * (off - on) * coasting - 0.5 * 2.0 / m * coasting**2
    np.testing.assert_allclose(run.x, expected, atol=1e-13)
    assert [kind for _, kind in run.events] == ["stick", "slip+", "stick"]
    np.testing.assert_allclose([t for t, _ in run.events], [0.0, on, rest], atol=1e-12)


def test_a_load_that_passes_the_limit_between_two_steps_is_seen() -> None:
    """A bump of the force, hardly above the static friction at its top, sets the resting mass free."""
    friction, times = 2.0, np.array([0.0, 1.0])
    rig = Oscillator(2.0, 0.0, 0.0, 0.0, 0.0, friction, 0.0)
    for top in np.linspace(0.4, 0.45, 11):
        for height, kinds in ((0.999, ["stick"]), (1.001, ["stick", "slip+", "stick"])):

            def bump(t: float, size: float = height * friction, top: float = float(top)) -> float:
                return size * cos(pi * (t - top)) ** 2

            run = rigid.simulate(rig, GivenDrive(0.1, u=bump), times)
            assert [kind for _, kind in run.events] == kinds


def test_wrong_input_is_refused() -> None:
    rig, drive, times = rig1987.rig(), no_drive(), np.array([0.0, 1.0])
    for simulate in (loaded.simulate, paper.simulate):
        with pytest.raises(ValueError, match="finite k1"):
            simulate(replace(rig, k1=inf), drive, times)
        with pytest.raises(ValueError, match=r"k1 \|z0\|"):
            simulate(rig, drive, times, 0.0, 0.0, 1.0)
        with pytest.raises(ValueError, match="increase"):
            simulate(rig, drive, times[::-1])
    with pytest.raises(ValueError, match="friction_against"):
        replace(rig, friction_against="guide")
    with pytest.raises(ValueError, match="negative"):
        replace(rig, A=-1.0)
    with pytest.raises(ValueError, match="positive"):
        replace(rig, mass=0.0)


def test_phase_of_the_sine() -> None:
    drive = SineDrive(2.0, 0.01, 0.3, 4.0, 0.9)
    t = 0.137
    assert drive.position(t) == pytest.approx(0.01 * sin(4.0 * pi * t + 0.3))
    assert drive.force(t) == pytest.approx(4.0 * sin(4.0 * pi * t + 0.9))
    before, after = t - 1e-5, t + 1e-5
    rate = (drive.position(after) - drive.position(before)) / 2e-5
    assert drive.velocity(t) == pytest.approx(rate, rel=1e-8)
    rate = (drive.velocity(after) - drive.velocity(before)) / 2e-5
    assert drive.acceleration(t) == pytest.approx(rate, rel=1e-8)
    expected = 7.0 * drive.position(t) + 0.2 * drive.velocity(t) + drive.force(t)
    assert drive.load(7.0, 0.2)(t) == pytest.approx(expected, rel=1e-12)
