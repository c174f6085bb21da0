"""The effects of the mechanics against closed forms, energies and rigs that have them built in."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import signal

from jaxstick.hypothesis import effects_at_null
from jaxstick.nominal import nominal
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parameter import find, replace
from jaxstick.parts.before import Before
from jaxstick.parts.contact import LoadedContact
from jaxstick.parts.drive import SineDrive
from jaxstick.parts.friction import ExponentialFriction
from jaxstick.parts.motion import Motion
from jaxstick.parts.rig import AbstractRig, Rig
from jaxstick.parts.track import Trace, Track
from jaxstick.simulate import Grid, Trajectory, march, simulate
from tests.jaxstick.rig1987_runs import RIG, constants

M, K = 2.0, 2000.0
NOMINAL = nominal(RIG, dataclasses.replace(constants(0.86), D=2.0), SineDrive(1.5, 10.325e-3))
SMOOTH = Oscillator(Rig(M, K, K), SineDrive(1.0), ExponentialFriction(0.0, 1.0, 0.0, 0.0), LoadedContact(1e4))
"""No friction, no damping."""


def with_effect(oscillator: Oscillator, key: str, **values: float) -> Oscillator:
    return replace(effects_at_null((key,))[key], values).attach(oscillator)


def simulated(oscillator: Oscillator, start: Start | None = None, samples: int = 1000) -> Any:
    """All constants are arrays, so that one program serves an effect whatever its values."""
    traced = jax.tree.map(jnp.asarray, (oscillator, start))
    run = simulate(traced[0], samples=samples, interval=1e-3, steps_per_sample=10, start=traced[1])
    return jax.tree.map(np.asarray, run)


SHORT = 8e-3


def levelled(far: np.ndarray) -> np.ndarray:
    """The integral of u^2/(1 + u) from 0."""
    return far**2 / 2 - far + np.log1p(far)


POTENTIALS: dict[str, tuple[dict[str, float], Callable[[np.ndarray], np.ndarray]]] = {
    "cubic_stiffness": ({"coefficient": 5e6}, lambda x: 5e6 * x**4 / 4),
    "quadratic_stiffness": (
        {"coefficient": 8e4, "length": SHORT},
        lambda x: 8e4 * SHORT**3 * np.sign(x) * levelled(np.abs(x) / SHORT),
    ),
    "end_stop": (
        {"stiffness": 3e3, "gap": 6e-3, "below": 1.2},
        lambda x: 3e3 * (np.maximum(x - 6e-3, 0.0) ** 2 + np.maximum(-x - 7.2e-3, 0.0) ** 2) / 2,
    ),
    "constant_force": ({"force": 2.0}, lambda x: -2.0 * x),
}


@pytest.mark.parametrize("key", POTENTIALS)
def test_energy_is_kept_with_the_effect_s_own_potential(key: str) -> None:
    values, potential = POTENTIALS[key]
    run = simulated(with_effect(SMOOTH, key, **values), Start(0.01))
    kinetic, spring, extra = M * run.v**2 / 2, K * run.x**2 / 2, potential(run.x)
    energy = kinetic + spring + extra
    assert np.ptp(energy) < 1e-5 * energy[0]
    assert np.ptp(kinetic + spring) > 0.05 * energy[0]


def work_over_a_cycle(rig: AbstractRig, amplitude: float, omega: float, cycles: int = 1) -> tuple[float, ...]:
    """The work of the rig's force along x = amplitude sin(omega t) in the last of some cycles [J], and its
    parts in phase with x and with v, as stiffness [N/m] and damping [N s/m]."""
    steps = 4000
    h = 2 * math.pi / omega / steps
    t = h * jnp.arange(cycles * steps + 1.0)
    zeros = jnp.zeros_like(t)
    x, v = amplitude * jnp.sin(omega * t), amplitude * omega * jnp.cos(omega * t)
    motion = Motion(t, x, v, -(omega**2) * x, zeros, zeros, zeros, zeros, x, v, jnp.ones_like(t), zeros)
    state = jax.tree.map(jnp.asarray, rig.initial(jax.tree.map(lambda a: a[0], motion)))

    def one(state, motion):
        force = rig.force(state, motion)
        return rig.advance(state, motion, h), force

    later = jax.tree.map(lambda a: a[1:], motion)
    state = rig.advance(state, jax.tree.map(lambda a: a[0], motion), h)
    force = np.asarray(jax.lax.scan(one, state, later)[1])[-steps:]
    sine, cosine = (np.asarray(part)[-steps:] for part in (jnp.sin(omega * t), jnp.cos(omega * t)))
    work = float(np.sum(force * np.asarray(v)[-steps:]) * h)
    stiffness = -2 * float(np.mean(force * sine)) / amplitude
    return work, stiffness, -2 * float(np.mean(force * cosine)) / (amplitude * omega)


@pytest.mark.parametrize("bend", [0.0, -1.5, 20.0])
def test_drag_takes_eight_thirds_of_its_coefficient_and_more_where_it_bends(bend: float) -> None:
    """The integral of |v|^3 over a cycle of X sin w t is 8/3 w^2 X^3, of v^4 it is 3 pi/4 w^3 X^4."""
    amplitude, omega, coefficient = 0.01, 12.0, 7.0
    rig = with_effect(SMOOTH, "quadratic_drag", coefficient=coefficient, bend=bend).rig
    work, stiffness, _ = work_over_a_cycle(rig, amplitude, omega)
    more = 0.75 * np.pi * bend * omega**3 * amplitude**4
    assert work == pytest.approx(-coefficient * (8 / 3 * omega**2 * amplitude**3 + more), rel=1e-6)
    assert stiffness == pytest.approx(K, rel=1e-9)


@pytest.mark.parametrize("rhythm", [0.2, 1.0, 5.0])
def test_a_relaxing_branch_has_maxwell_s_complex_stiffness(rhythm: float) -> None:
    time, stiffness = 0.1, 50.0
    omega = rhythm / time
    rig = with_effect(SMOOTH, "spring_relaxation", stiffness=stiffness, time=time).rig
    branch = stiffness * 1j * rhythm / (1 + 1j * rhythm)
    _, storage, loss = work_over_a_cycle(rig, 0.01, omega, cycles=20)
    assert storage - K == pytest.approx(branch.real, rel=1e-4)
    assert loss * omega == pytest.approx(branch.imag, rel=1e-4)


def test_a_relaxing_branch_begins_where_a_harmonic_motion_has_brought_it() -> None:
    """With the mass on its way at the drive's own frequency there is no transient from the first step on."""
    time, stiffness, omega = 0.1, 50.0, 2 * math.pi * 1.5
    oscillator = dataclasses.replace(SMOOTH, drive=SineDrive(1.5, 0.01))
    rig = with_effect(oscillator, "spring_relaxation", stiffness=stiffness, time=time).rig
    first, settled = (work_over_a_cycle(rig, 0.01, omega, cycles) for cycles in (1, 8))
    assert first == pytest.approx(settled, rel=1e-3)


def test_a_relaxing_branch_picked_up_in_a_record_begins_where_the_motion_has_brought_it() -> None:
    """Of a motion that no single sine describes; from a start at rest, and in full swing."""
    time, stiffness = 0.8, 50.0
    rig = with_effect(SMOOTH, "spring_relaxation", stiffness=stiffness, time=time).rig
    lags = np.linspace(0.0, 20.0, 40001)
    t = 21.0 - lags
    x = 0.01 * np.sin(2 * np.pi * 0.5 * t) ** 3 + 0.004 * np.sign(np.sin(2 * np.pi * 0.125 * t))
    w = signal.lfilter([1 - np.exp(-5e-4 / time)], [1, -np.exp(-5e-4 / time)], x[::-1] - x[-1])[-1] + x[-1]
    here = Motion(21.0, x[0], *(0.0,) * 8, direction=1.0)
    bare = float(SMOOTH.rig.force(SMOOTH.rig.initial(here), here))
    for part in (slice(None), slice(0, 24001)):
        start = here._replace(
            track=Track(jnp.asarray(lags[part]), jnp.asarray(x[part]), jnp.zeros(len(lags[part])))
        )
        held = float(rig.force(rig.initial(start), here)) - bare
        assert held == pytest.approx(-stiffness * (x[0] - w), rel=2e-3)


def test_what_follows_a_trace_is_exact_on_straight_lines_and_differentiable() -> None:
    """w of a ramp lags by its rate times time; the slope in time is that of central differences."""
    trace = Trace(jnp.array([0.0, 0.3, 0.5, 2.0]), 5.0 - 1.5 * jnp.array([0.0, 0.3, 0.5, 2.0]))
    assert float(trace.followed(0.1, 2.0)) == pytest.approx(5.0 - 1.5 * 0.1, abs=1e-8)
    assert float(trace.followed(1e4, 2.0)) == pytest.approx(2.0 + 1.5 * 2.0**2 / 2 / 1e4, abs=1e-6)

    def followed(time: Any) -> Any:
        return trace.followed(time, 2.5)

    slope = (float(followed(0.7001)) - float(followed(0.6999))) / 2e-4
    assert float(jax.grad(followed)(0.7)) == pytest.approx(slope, rel=1e-6)
    assert float(jax.jvp(followed, (0.7,), (1.0,))[1]) == pytest.approx(slope, rel=1e-6)
    assert np.all(np.isfinite([jax.grad(followed)(time) for time in (1e-6, 1e6)]))


def test_a_rubbing_guide_takes_equal_steps_off_the_swing() -> None:
    """4 force/K a cycle (Lorenz 1924), less for the stretch in which the guide yields, and none in F."""
    force, deflection = 0.5, 1e-7
    rubbed = with_effect(SMOOTH, "guide_friction", force=force, deflection=deflection)
    half = math.pi * math.sqrt(M / K)
    run = simulate(rubbed, samples=7, interval=half, steps_per_sample=40000, start=Start(0.01, 0.0))
    swings = np.abs(np.asarray(run.x))
    assert -np.diff(swings) == pytest.approx(np.full(6, 2 * force / K), rel=5e-3)
    assert np.abs(np.asarray(run.force)).max() == 0.0


def test_a_rubbing_guide_sticks_with_the_mass() -> None:
    """Left to itself beyond its rest position, the mass comes to rest there, held by the guide alone."""
    rubbed = with_effect(SMOOTH, "guide_friction", force=1.0, deflection=2e-5)
    rubbed = dataclasses.replace(rubbed, drive=SineDrive(0.5, 4e-4))
    run = simulated(rubbed, Start(), 4000)
    assert np.abs(run.x).max() < 2e-5
    assert np.all(np.isfinite(run.x))


@pytest.mark.parametrize("slid", [-1.0, 0.0, 1.0])
def test_a_guide_that_a_sliding_mass_has_come_to_rest_on_still_pushes_back(slid: float) -> None:
    """Until the mass goes back by the guide's deflection; nothing where it has not slid."""
    rubbed = with_effect(SMOOTH, "guide_friction", force=1.0, deflection=2e-5)
    state = rubbed.initial(jnp.asarray(0.0), Start(1e-3, 0.0, before=Before(slid=slid)))
    motion = rubbed.motion(jnp.asarray(0.0), rubbed.drive.at(0.0), 1e-3, 0.0, 0.0)
    still = SMOOTH.rig.force(SMOOTH.rig.initial(motion), motion)
    assert float(rubbed.rig.force(state.rig, motion) - still) == pytest.approx(-slid)
    back = motion._replace(x=1e-3 - 1e-5 * slid)
    held = rubbed.rig.force(state.rig, back) - SMOOTH.rig.force(SMOOTH.rig.initial(motion), back)
    assert float(held) == pytest.approx(-slid * 0.5)


def test_a_guide_yields_while_the_mass_sticks_and_is_picked_up_there() -> None:
    """The contact spring gives way by more than the guide's deflection while its force turns round. A motion
    picked up in the middle of that goes on as the whole one does."""
    force, deflection, interval = 0.5, 2e-5, 1e-3
    rubbed = with_effect(NOMINAL, "guide_friction", force=force, deflection=deflection)
    rubbed = dataclasses.replace(rubbed, drive=SineDrive(0.6, 10.325e-3))
    run = simulated(rubbed, samples=3000)
    share, sense = np.zeros(len(run.x)), np.zeros(len(run.x))
    for i in range(1, len(run.x)):
        share[i] = np.clip(share[i - 1] + (run.x[i] - run.x[i - 1]) / deflection, -1, 1)
        sense[i] = np.sign(run.v[i]) if abs(run.v[i]) > 5e-3 else sense[i - 1]
    within = np.flatnonzero((np.abs(share) < 0.8) & (np.arange(len(run.x)) > 1500))[:-60]
    assert len(within) > 200
    state = jax.jit(
        jax.vmap(
            lambda x, v, f, slid: (
                rubbed.initial(jnp.zeros(()), Start(x, v, f, Before(slid=slid))).rig[1].share
            )
        )
    )(*(values[within] for values in (run.x, run.v, run.force, sense)))
    assert np.abs(np.asarray(state) - share[within]).mean() < 0.2
    go_on = jax.jit(lambda start, time: march(rubbed, start, Grid(time, interval, 60, 10)))
    for i in within[:: len(within) // 4]:
        start = Start(
            *(float(part[i]) for part in (run.x, run.v, run.force)), before=Before(slid=float(sense[i]))
        )
        on = go_on(start, i * interval)
        assert np.abs(np.asarray(on.force) - run.force[i : i + 60]).max() < 0.6 * force


@pytest.mark.parametrize("fast", [False, True])
def test_a_lubricated_guide_creeps(fast: bool) -> None:
    """Between two times ds/dt = (v - creep s)/deflection, against its own solution for constant velocity; a
    guide that creeps fast brakes as the velocity, up to its whole force."""
    force, deflection, creep = 1.5, 2e-5, 2.0 if fast else 1e-3
    rubbed = with_effect(SMOOTH, "guide_friction", force=force, deflection=deflection, creep=creep)
    state = rubbed.initial(jnp.asarray(0.0), Start(0.0, 0.0, before=Before(slid=1.0)))
    motion = rubbed.motion(jnp.asarray(0.0), rubbed.drive.at(0.0), 0.0, 0.0, 0.0)
    plain = SMOOTH.rig.initial(motion)
    rig, step, v = state.rig, 1e-4, -4e-4
    for n in range(1, 201):
        motion = motion._replace(t=n * step, x=v * n * step)
        rig = rubbed.rig.advance(rig, motion, step)
        if n in (1, 20, 200):
            decay = math.exp(-creep * n * step / deflection)
            share = decay + v / creep * (1 - decay)
            added = float(rubbed.rig.force(rig, motion) - SMOOTH.rig.force(plain, motion))
            assert added == pytest.approx(-force * share, rel=1e-6, abs=1e-9)
    motion = motion._replace(t=motion.t + 1.0, x=motion.x - 9.0)
    added = float(rubbed.rig.force(rig, motion) - SMOOTH.rig.force(plain, motion))
    assert added == pytest.approx(force)


@pytest.mark.parametrize("braking", [0.0, 1.0])
def test_damping_to_the_base_is_the_rig_s_own(braking: float) -> None:
    """A forgotten damper between mass and base brakes the mass as well."""
    damping = float(find(NOMINAL, "rig.damping").of(NOMINAL)) + 1.3 * braking
    built_in = replace(NOMINAL, {"rig.drive_damping": 1.3, "rig.damping": damping})
    attached = with_effect(NOMINAL, "base_relative_damping", damping=1.3, braking=braking)
    one, other = simulated(built_in), simulated(attached)
    assert np.abs(one.x - other.x).max() < 1e-11
    assert np.abs(one.x - simulated(NOMINAL).x).max() > 1e-5


def test_what_is_misstated_is_the_rig_s_own() -> None:
    truth = {"rig.mass": 2.5, "rig.stiffness": 2100.0, "rig.drive_stiffness": 2050.0}
    values = {"mass": 0.12, "stiffness": 64.0, "ground_stiffness": 50.0}
    attached = with_effect(NOMINAL, "stiffness_error", **values)
    assert np.abs(simulated(replace(NOMINAL, truth)).x - simulated(attached).x).max() < 1e-11


def test_play_is_the_play_operator() -> None:
    """The rig sees the base of a drive that went through the play operator, written out in a loop."""
    gap, omega, h = 1.5e-3, 2 * math.pi, 1e-3
    t = h * np.arange(1500)
    y = 0.01 * np.sin(omega * t) * np.exp(-0.5 * t)
    joint = [y[0] - gap]
    for place in y[1:]:
        joint.append(min(max(joint[-1], place - gap), place + gap))
    rig = with_effect(SMOOTH, "drive_backlash", gap=gap).rig
    zeros = jnp.zeros_like(jnp.asarray(y))
    base = jnp.asarray(y), jnp.asarray(np.gradient(y, h))
    motion = Motion(jnp.asarray(t), zeros, zeros, zeros, *base, zeros, zeros, zeros, zeros, zeros, zeros)
    state = rig.initial(jax.tree.map(lambda a: a[0], motion))

    def one(state, motion):
        return rig.advance(state, motion, h), rig.force(state, motion)

    forces = np.asarray(jax.lax.scan(one, state, motion)[1])
    assert forces == pytest.approx(K * np.array(joint), abs=1e-9)


@pytest.mark.parametrize("since", [0.004, 0.02, 0.06, 0.3])
def test_a_joint_picked_up_in_a_record_is_where_the_base_has_taken_it(since: float) -> None:
    """So long after a drive has turned back [s] the joint still rests, or has been taken along again."""
    gap, omega = 5e-4, 2 * math.pi
    lags = 4 * np.sinh(3 * np.linspace(0, 1, 96)) / math.sinh(3)
    y = 0.01 * np.cos(omega * (since - lags))
    rig = with_effect(SMOOTH, "drive_backlash", gap=gap).rig
    track = Track(jnp.asarray(lags), jnp.zeros(96), jnp.asarray(y))
    rate = -0.01 * omega * math.sin(omega * since)
    motion = SMOOTH.motion(0.0, SMOOTH.drive.at(0.0), 0.0, 0.0, 0.0)
    motion = motion._replace(y=y[0], y_rate=rate, track=track)
    expected = min(0.01 - gap, y[0] + gap)
    assert float(rig.force(rig.initial(motion), motion)) == pytest.approx(K * expected, abs=K * 0.02 * gap)


@pytest.mark.parametrize("floating", [1.0, 0.3])
def test_a_spring_whose_joint_nothing_holds_is_slack_in_the_gap(floating) -> None:
    """Dead zone; where the joint is held in part, the spring goes as much by the play operator."""
    gap, ground = 1.5e-3, 300.0
    bare = dataclasses.replace(SMOOTH, rig=Rig(M, K + ground, K, 0.0, 0.0))
    rig = with_effect(bare, "drive_backlash", gap=gap, floating=floating).rig
    motion = bare.motion(0.0, bare.drive.at(0.0), 0.0, 0.0, 0.0)._replace(y_rate=1.0)
    state = rig.initial(motion)
    for stretch in (-4e-3, -1e-3, 0.0, 1.4e-3, 5e-3):
        now = motion._replace(y=motion.y + stretch + 2e-4, x=2e-4)
        slack = K * (stretch - min(max(stretch, -gap), gap)) - ground * now.x
        held = K * (min(max(-gap, now.y - gap), now.y + gap) - now.x) - ground * now.x
        assert float(rig.force(state, now)) == pytest.approx(floating * slack + (1 - floating) * held)


def test_a_damper_behind_the_play_rests_while_the_gap_is_crossed() -> None:
    rig = with_effect(
        dataclasses.replace(SMOOTH, rig=Rig(M, K, 0.0, 5.0, 5.0)), "drive_backlash", gap=1e-3
    ).rig
    motion = SMOOTH.motion(0.0, SMOOTH.drive.at(0.0), 0.0, 0.0, 0.0)._replace(y_rate=0.1)
    state = rig.initial(motion)
    back = motion._replace(y=motion.y - 1e-3, y_rate=-0.1)
    beyond = motion._replace(y=motion.y - 3e-3, y_rate=-0.1)
    assert [float(rig.force(state, one)) for one in (motion, back, beyond)] == pytest.approx([0.5, 0, -0.5])


MECHANICS = {
    "base_relative_damping": {"damping": 1.0},
    "constant_force": {"force": 0.4},
    "cubic_stiffness": {"coefficient": 1e6},
    "drive_backlash": {"gap": 5e-5},
    "end_stop": {"stiffness": 300.0},
    "guide_friction": {"force": 0.2},
    "quadratic_drag": {"coefficient": 2.0},
    "quadratic_stiffness": {"coefficient": 1e4},
    "spring_relaxation": {"stiffness": 40.0},
    "stiffness_error": {"stiffness": 40.0, "ground_stiffness": 40.0, "mass": 0.05},
}
START = Start(1e-3, 0.1, -2.0)
GRID = Grid(0.1, 2e-3, 250, 4)


@jax.jit
def travelled(oscillator: Oscillator) -> Trajectory:
    return march(oscillator, START, GRID)


def test_mechanics_effects_attach_in_any_order() -> None:
    """Forwards and backwards give the same motion to a hundredth of what they do: only play, which changes
    what the parts behind it see, is not simply added."""
    effects = {key: replace(effects_at_null((key,))[key], values) for key, values in MECHANICS.items()}
    ahead = behind = NOMINAL
    for key in effects:
        ahead = effects[key].attach(ahead)
    for key in reversed(effects):
        behind = effects[key].attach(behind)
    one, other, without = (np.asarray(travelled(oscillator).x) for oscillator in (ahead, behind, NOMINAL))
    assert np.abs(one - other).max() < 0.01 * np.abs(one - without).max()


def test_mechanics_effects_at_null_change_no_bit() -> None:
    together = NOMINAL
    for effect in effects_at_null(tuple(MECHANICS)).values():
        together = effect.attach(together)
    for one, other in zip(travelled(together), travelled(NOMINAL), strict=True):
        assert np.abs(np.asarray(one) - np.asarray(other)).max() <= 1e-13 * np.abs(np.asarray(other)).max()


def test_derivatives_at_null_with_all_mechanics_effects_attached() -> None:
    """By every strength together, from inside, against one-sided differences."""
    hypothesis = effects_at_null(tuple(MECHANICS))
    names = [(key, name) for key, values in MECHANICS.items() for name in values]
    sizes = np.array([MECHANICS[key][name] for key, name in names])

    @jax.jit
    def motion(point):
        oscillator = NOMINAL
        for key in MECHANICS:
            given = {name: point[i] for i, (owner, name) in enumerate(names) if owner == key}
            oscillator = replace(hypothesis[key], given).attach(oscillator)
        run = march(oscillator, START, GRID)
        return jnp.concatenate([run.displacement / 1e-2, run.friction / 7.0])

    null = jnp.zeros(len(names))
    jacobian = np.asarray(jax.jit(jax.jacfwd(motion))(null)) * sizes
    base = np.asarray(motion(null))
    for index, (key, name) in enumerate(names):
        step = np.zeros(len(names))
        step[index] = 1e-5 * sizes[index]
        difference = (np.asarray(motion(jnp.asarray(step))) - base) / 1e-5
        size = np.abs(jacobian[:, index]).max()
        assert size > 1e-4, (key, name)
        assert np.abs(difference - jacobian[:, index]).max() < 1e-3 * size, (key, name)
