"""The friction effects against closed forms and against the law written out in numpy."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.compiled import QUICKLY
from jaxstick.effect import Leftover
from jaxstick.hypothesis import effects_at_null
from jaxstick.nominal import nominal
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parameter import replace
from jaxstick.parts.before import Before
from jaxstick.parts.contact import Approach, LoadedContact, Passage, SmoothContact, Traction
from jaxstick.parts.drive import AbstractDrive, Excitation, RecordedDrive, SineDrive
from jaxstick.parts.friction import ExponentialFriction
from jaxstick.parts.rig import Rig
from jaxstick.parts.track import Trace, Track
from jaxstick.simulate import Grid, OpenGrid, march, simulate
from tests.jaxstick.fit_grid import open_grid
from tests.jaxstick.rig1987_runs import RIG, constants

A, B, C, D, K1 = 2.0, 40.0, 6.0, 3.0, 1e5
LAW = ExponentialFriction(A, B, C, D)
STATIC = A + C
DRIVE = SineDrive(1.5, 10.325e-3)
NOMINAL = nominal(RIG, dataclasses.replace(constants(0.86), A=A, B=B, C=C, D=D, k1=K1), DRIVE)


def with_effect(oscillator: Oscillator, key: str, **values: float) -> Oscillator:
    return replace(effects_at_null((key,))[key], values).attach(oscillator)


def simulated(oscillator: Oscillator) -> Any:
    """Its constants are arrays, so that one program serves an effect whatever its values."""
    traced = jax.tree.map(jnp.asarray, oscillator)
    run = simulate(traced, samples=2000, interval=1e-3, steps_per_sample=10)
    return jax.tree.map(np.asarray, run)


marched = jax.jit(march, compiler_options=QUICKLY)


def slipping(run: Any) -> np.ndarray:
    """Samples well inside slip: the stuck mass rings at up to 0.016 m/s."""
    return np.abs(np.asarray(run.v)) > 0.1


def law(speed: np.ndarray) -> np.ndarray:
    return A * np.exp(-B * speed) + C + D * speed


WAVE = 2 * math.pi / 4e-3

FACTORS: dict[str, tuple[dict[str, float], Callable[[Any], np.ndarray]]] = {
    "position_dependent_friction": (
        {"gradient": 12.0, "curvature": 900.0},
        lambda run: 12.0 * run.x + 900.0 * run.x**2,
    ),
    "periodic_track": (
        {"cosine": 0.1, "sine": -0.2, "wavelength": 4e-3},
        lambda run: 0.1 * np.cos(WAVE * run.x) - 0.2 * np.sin(WAVE * run.x),
    ),
    "load_variation": (
        {"in_phase": 0.1, "quadrature": 0.05, "at_ends": 0.06, "before_ends": -0.04},
        lambda run: (
            0.1 * np.sin(3 * math.pi * run.time)
            + 0.05 * np.cos(3 * math.pi * run.time)
            - 0.06 * np.cos(6 * math.pi * run.time)
            - 0.04 * np.sin(6 * math.pi * run.time)
        ),
    ),
    "friction_drift": ({"rate": 0.2, "time": 0.7}, lambda run: 0.14 * (1 - np.exp(-run.time / 0.7))),
}


@pytest.mark.parametrize("wavelength", [3e-3, 0.5e-3])
def test_the_wavelength_of_a_track_is_read_off_what_the_smooth_law_leaves(wavelength: float) -> None:
    """A ripple of 3 % of the force under noise a third as large, so fine that no grid of a few wavelengths
    would meet it: over the whole stroke, the phase holds to a third of a turn."""
    key = "periodic_track"
    run = simulated(with_effect(NOMINAL, key, cosine=0.02, sine=-0.02, wavelength=wavelength))
    friction = -np.sign(run.v) * law(np.abs(run.v))
    noise = 0.08 * np.random.default_rng(2).standard_normal(len(run.time))
    leftover = Leftover(run.time, run.x, run.v, friction, run.force - friction + noise)
    found = type(effects_at_null((key,))[key]).read_off(leftover)
    waves = float(np.ptp(run.x)) / wavelength
    assert found["wavelength"] == pytest.approx(wavelength, rel=0.3 / waves)


def test_nothing_is_read_off_a_mass_at_rest() -> None:
    for effect in effects_at_null(("periodic_track", "friction_drift")).values():
        for rest in (np.zeros(0), np.zeros(20)):
            assert effect.read_off(Leftover(rest, rest, rest, rest, rest)) == {}


def test_friction_along_a_track_may_level_off() -> None:
    """As a worn track does towards the ends of the stroke."""
    values = {"gradient": 15.0, "length": 6e-3}
    run = simulated(with_effect(NOMINAL, "position_dependent_friction", **values))
    slip, excess = slipping(run), 15.0 * 6e-3 * np.tanh(run.x / 6e-3)
    expected = -np.sign(run.v) * law(np.abs(run.v)) * (1 + excess)
    assert np.abs(run.force - expected)[slip].max() < 2e-3 * STATIC
    assert np.abs(15.0 * run.x - excess)[slip].max() > 0.02


@pytest.mark.parametrize("key", FACTORS)
def test_a_factor_multiplies_the_whole_law(key: str) -> None:
    values, excess = FACTORS[key]
    run = simulated(with_effect(NOMINAL, key, **values))
    slip = slipping(run)
    assert slip.sum() > 300
    expected = -np.sign(run.v) * law(np.abs(run.v)) * (1 + excess(run))
    assert np.abs(run.force - expected)[slip].max() < 2e-3 * STATIC
    assert np.abs(excess(run)[slip]).max() > 0.05


def test_the_two_directions_differ_by_their_own_shares() -> None:
    run = simulated(with_effect(NOMINAL, "asymmetric_friction", dry=0.1, viscous=0.3))
    slip, sign, speed = slipping(run), np.sign(run.v), np.abs(run.v)
    dry = (A * np.exp(-B * speed) + C) * (1 + 0.1 * sign)
    expected = -sign * (dry + D * speed * (1 + 0.3 * sign))
    assert np.abs(run.force - expected)[slip].max() < 2e-3 * STATIC


@pytest.mark.parametrize("steady", [0.4, 1.0])
def test_the_directions_may_differ_by_what_does_not_weaken_with_speed(steady: float) -> None:
    run = simulated(with_effect(NOMINAL, "asymmetric_friction", dry=0.1, steady=steady))
    slip, sign, speed = slipping(run), np.sign(run.v), np.abs(run.v)
    dry = A * np.exp(-B * speed) + C
    expected = -sign * (dry + D * speed) - 0.1 * (steady * STATIC + (1 - steady) * dry)
    assert np.abs(run.force - expected)[slip].max() < 2e-3 * STATIC
    assert 0.1 * steady * (STATIC - dry)[slip].max() > 5e-3 * STATIC


@pytest.mark.parametrize("excess", [-0.5, 1.0])
def test_the_stribeck_curve_takes_another_exponent(excess: float) -> None:
    reference = 0.03
    run = simulated(with_effect(NOMINAL, "stribeck_shape", excess=excess, reference=reference))
    speed = np.abs(run.v)
    decay = (B * reference**-excess) ** (1 / (1 + excess))
    dry = A * np.exp(-((decay * speed) ** (1 + excess))) + C
    slow = (speed > 0.05) & (speed < 0.3)
    assert slow.sum() > 50
    assert np.abs(run.force + np.sign(run.v) * (dry + D * speed))[slow].max() < 2e-3 * STATIC
    assert np.abs(dry + D * speed - law(speed))[slow].max() > 0.02 * STATIC


@pytest.mark.parametrize(("excess", "tail"), [(-0.4, 1.0), (0.3, 0.9), (1.0, 0.5)])
def test_the_stribeck_curve_may_fall_as_a_power_of_the_speed(excess: float, tail: float) -> None:
    reference = 0.03
    run = simulated(with_effect(NOMINAL, "stribeck_shape", excess=excess, reference=reference, tail=tail))
    speed = np.abs(run.v)
    slower, relative = tail * abs(excess), (speed / reference) ** (1 + excess)
    dry = A * (1 + slower * relative) ** (-B * reference / slower)
    without = A * np.exp(-B * reference * relative)
    slow = (speed > 0.05) & (speed < 0.3)
    assert slow.sum() > 50
    assert np.abs(run.force + np.sign(run.v) * (dry + C + D * speed))[slow].max() < 2e-3 * STATIC
    assert np.abs(dry - without)[slow].max() > 0.01 * STATIC


@pytest.mark.parametrize(("growth", "film"), [(0.03, 0.0), (-0.02, 0.0), (0.0, 5.0), (0.03, -5.0)])
def test_friction_grows_with_the_logarithm_and_the_square_of_the_speed(growth: float, film: float) -> None:
    reference = 2e-3
    run = simulated(
        with_effect(NOMINAL, "velocity_strengthening", growth=growth, reference=reference, film=film)
    )
    slip, speed = slipping(run), np.abs(run.v)
    added = STATIC * (growth * np.log(1 + speed / reference) + film * speed**2)
    assert slip.sum() > 50
    assert np.abs(run.force + np.sign(run.v) * (law(speed) + added))[slip].max() < 2e-3 * STATIC
    assert np.abs(added)[slip].max() > 0.05 * STATIC


def test_friction_that_weakens_with_speed_never_turns_round() -> None:
    """By a quarter of itself an e-fold, for nine of them: what stays is a twentieth of what the law says."""
    run = simulated(with_effect(NOMINAL, "velocity_strengthening", growth=-0.25, reference=1e-5))
    slip, speed = slipping(run), np.abs(run.v)
    assert slip.sum() > 50
    left = 0.05 * (A * np.exp(-B * speed) + C) + D * speed
    assert np.abs(run.force + np.sign(run.v) * left)[slip].max() < 2e-3 * STATIC


def test_load_follows_a_recorded_base_by_its_own_amplitude() -> None:
    """A sine given by samples varies the load as the sine itself does, at any amplitude and frequency."""
    times = np.arange(0.0, 2.0, 2e-3)
    turns = 3 * math.pi * times
    recorded = RecordedDrive.through(0.0, 2e-3, base=10.325e-3 * np.sin(turns))
    assert list(recorded.extent()) == pytest.approx(list(DRIVE.extent()), rel=2e-3)
    rates = [
        simulated(
            with_effect(
                dataclasses.replace(NOMINAL, drive=drive), "load_variation", in_phase=0.1, quadrature=0.1
            )
        ).force
        for drive in (recorded, DRIVE)
    ]
    assert np.abs(rates[0] - rates[1]).max() < 5e-3 * STATIC


def test_load_follows_the_force_where_the_base_stands_still() -> None:
    drive = SineDrive(1.5, 0.0, 20.0)
    driven, twice = dataclasses.replace(NOMINAL, drive=drive), {"at_ends": 0.05, "before_ends": 0.2}
    run = simulated(with_effect(driven, "load_variation", in_phase=0.1, **twice))
    slip, phase = slipping(run), 3 * math.pi * run.time
    expected = law(np.abs(run.v)) * (1 + 0.1 * np.sin(phase) - 0.05 * np.cos(2 * phase))
    assert slip.sum() > 100
    assert np.abs(np.abs(run.force) - expected)[slip].max() < 2e-3 * STATIC


class Still(AbstractDrive):
    """No excitation at all."""

    def at(self, t):
        nothing = jnp.zeros_like(jnp.asarray(t))
        return Excitation(nothing, nothing, nothing, nothing)

    def extent(self):
        return SineDrive(0.0).extent()


def free(law: ExponentialFriction, k1: float = K1, drive: AbstractDrive | None = None) -> Oscillator:
    """A mass of 2 kg without springs."""
    return Oscillator(Rig(2.0, 0.0, 0.0), drive or Still(), law, LoadedContact(k1))


def contact_of(key: str, contact=None, **values: float):
    rig = free(LAW)
    return with_effect(
        rig if contact is None else dataclasses.replace(rig, contact=contact), key, **values
    ).contact


def dragged(contact, path: np.ndarray, step: float, rest: float = 0.0) -> np.ndarray:
    """The friction force on a slider that is led along `path` [m] from an unloaded contact, node by node."""
    return np.asarray(_dragged(contact, jnp.asarray(path), step, rest))


@jax.jit
def _dragged(contact, path, step, rest):
    traction = Traction(
        lambda rate, direction: A * jnp.exp(-B * jnp.abs(rate)) + C, lambda rate, direction: jnp.asarray(0.0)
    )
    friction, state = contact.initial(Approach(jnp.asarray(0.0), jnp.asarray(0.0), rest), traction)
    slides = jnp.diff(path)
    rates = jnp.concatenate([(slides[1:] + slides[:-1]) / 2, slides[-1:]]) / step

    def one(state, given):
        slide, rate = given
        passage = Passage(jnp.asarray(step), slide, rate, jnp.asarray(0.0), jnp.asarray(1e6))
        grip = contact.grip(state, passage, traction)
        return grip.state, grip.friction

    state = jax.tree.map(jnp.asarray, state)
    return jnp.concatenate([friction[None], jax.lax.scan(one, state, (slides, rates))[1]])


def test_friction_lags_a_ramp_of_velocity_by_the_lag() -> None:
    """In steady acceleration from v0 the lagging velocity is v - a lag (1 - exp(-t/lag)) - w0 exp(-t/lag)."""
    lag, step, acceleration = 4e-3, 2e-5, 1.0
    t = step * np.arange(3000)
    force = dragged(contact_of("frictional_memory", lag=lag), acceleration * t**2 / 2 + 2e-3 * t, step)
    lagging = 2e-3 + acceleration * (t - lag * (1 - np.exp(-t / lag))) - 2e-3 * np.exp(-t / lag)
    slip = t > 0.02
    assert np.abs(force + A * np.exp(-B * lagging) + C)[slip].max() < 2e-3 * A
    assert np.abs(law(acceleration * t) - D * acceleration * t + force)[slip].max() > 0.03 * A


@pytest.mark.parametrize("curvature", [0.05, 0.25, 1 / 3])
def test_friction_sees_a_swinging_velocity_through_the_response_of_the_lag(curvature: float) -> None:
    """1/(1 + i o lag - curvature (o lag)^2), whether the velocity lags or its size: it has one sign."""
    lag, step, omega = 0.02, 1e-4, 40.0
    t = step * np.arange(8000)
    speed = 0.02 + 0.01 * np.imag(
        np.exp(1j * omega * t) / (1 + 1j * omega * lag - curvature * (omega * lag) ** 2)
    )
    path = 0.02 * t - 0.01 / omega * np.cos(omega * t)
    for unsigned in (0.0, 1.0):
        contact = contact_of("frictional_memory", lag=lag, curvature=curvature, unsigned=unsigned)
        force = -dragged(contact, path, step)
        late = t > 0.5
        assert np.abs(force - A * np.exp(-B * speed) - C)[late].max() < 2e-3 * A


def test_what_lags_is_the_velocity_or_its_size() -> None:
    """Behind a fast swing to and fro the one hardly moves, the other stays near the mean of the speed."""
    step, omega, lag = 5e-4, 20.0, 2.0
    t = step * np.arange(40000)
    path = 0.02 / omega * (1 - np.cos(omega * t))
    slip = (t > 14.0) & (np.abs(np.sin(omega * t)) > 0.9)
    for unsigned, speed in ((0.0, 0.0), (1.0, 0.02 * 2 / math.pi)):
        force = np.abs(dragged(contact_of("frictional_memory", lag=lag, unsigned=unsigned), path, step))
        assert np.abs(force - A * math.exp(-B * speed) - C)[slip].max() < 0.05 * A


def test_a_lag_in_time_becomes_one_over_a_distance() -> None:
    """After a jump of velocity what is seen has come 1 - 1/e of the way a length lag transition further on,
    at either speed."""
    step, length = 1e-5, 1e-4
    for speed in (0.01, 0.04):
        path = np.concatenate([2e-3 * step * np.arange(10000), 0.02 + speed * step * np.arange(1, 2000)])
        path[10000:] += path[9999] - 0.02
        contact = contact_of("frictional_memory", lag=1e3 * length, transition=1e-3, curvature=0.0)
        force = -dragged(contact, path, step)[10000:]
        seen = -np.log((force - C) / A) / B
        there = np.argmin(np.abs(path[10000:] - path[9999] - length))
        sooner = 1 + 1 / (1e3 * speed)
        assert (seen[there] - 2e-3) / (speed - 2e-3) == pytest.approx(1 - math.exp(-sooner), abs=0.01)


@pytest.mark.parametrize(("at", "transition"), [(1203, 1e3), (1287, 0.05), (1497, 1e3), (1623, 0.05)])
def test_a_motion_that_is_picked_up_remembers_how_it_slid(at: int, transition: float) -> None:
    """Friction goes on as in the run from its start, on a guide carried by the base too; a motion of which
    nothing is known before begins as if it had always slid so."""
    lagging = with_effect(NOMINAL, "frictional_memory", lag=0.06, transition=transition)
    run = simulated(lagging)
    lags = 1e-3 * np.arange(1204)
    before = at - np.arange(1204)
    base = np.asarray(DRIVE.at(jnp.asarray(run.time[before])).y)
    track = Track(lags, run.x[before], base)
    begin = Start(run.x[at], run.v[at], run.friction[at], Before(track=track))

    def astray(start: Start) -> float:
        seen = marched(lagging, start, Grid(1e-3 * at, 1e-3, 100, 10))
        return float(np.abs(seen.friction - run.friction[at : at + 100]).max())

    assert astray(begin) < 2e-3 < 0.4 < astray(begin._replace(before=Before()))


def test_a_lag_makes_a_loop_that_is_higher_while_speeding_up() -> None:
    step, omega = 1e-4, 2 * math.pi * 3
    t = step * np.arange(int(1 / step))
    path = 0.05 * t - 0.045 / omega * np.cos(omega * t)
    force = -dragged(contact_of("frictional_memory", lag=4e-3), path, step)
    speed = 0.05 + 0.045 * np.sin(omega * t)
    late, rising = t > 0.4, np.cos(omega * t) > 0.3
    falling = np.cos(omega * t) < -0.3
    steady = A * np.exp(-B * speed) + C
    assert np.all((force - steady)[late & rising] > 0)
    assert np.all((force - steady)[late & falling] < 0)


def strengthened(age: float, power: float) -> float:
    """The logarithm of 1 + age, or its power, which has an end where that is negative."""
    return math.log1p(age) if power == 0 else ((1 + age) ** power - 1) / power


@pytest.mark.parametrize(
    ("rest", "before", "power"),
    [(0.02, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 1.5, 0.0), (2.0, 0.0, 0.3), (2.0, 0.0, -1.5)],
)
def test_breakaway_grows_with_the_logarithm_of_rest_or_a_power(
    rest: float, before: float, power: float
) -> None:
    """`rest` seconds in stick and `before` of them earlier than the start, then a slow pull."""
    step, growth, cutoff, distance = 1e-3, 0.04, 0.01, 2e-5
    pull = 1e-3 * step * np.arange(1, 400)
    path = np.concatenate([np.zeros(round(rest / step) + 1), pull])
    contact = contact_of("dwell_strengthening", growth=growth, cutoff=cutoff, distance=distance, power=power)
    force = -dragged(contact, path, step, rest=before)
    creeping = A * math.exp(-B * 1e-3) + C
    age, expected = 0.0, creeping
    for _ in range(5):  # the age at breakaway counts the time of loading
        age = rest + before + expected / K1 / 1e-3
        expected = creeping * (1 + growth * strengthened(age / cutoff, power))
    assert force.max() == pytest.approx(expected, rel=2e-3)
    assert force[-1] == pytest.approx(creeping, rel=1e-3)
    slid = (np.arange(len(path)) - np.argmax(force)) * 1e-3 * step
    left = strengthened(age * math.exp(-1) / cutoff, power) / strengthened(age / cutoff, power)
    there = np.argmin(np.abs(slid - distance))
    assert (force[there] - force[-1]) / (force.max() - force[-1]) == pytest.approx(left, abs=0.05)


def test_what_ages_while_it_slips_has_the_age_of_a_distance() -> None:
    """distance/|v| in steady slip (Dieterich), from the start on where that is in slip."""
    step, speed, growth, cutoff, distance = 1e-4, 2e-3, 0.04, 1e-3, 1e-4
    contact = contact_of("dwell_strengthening", growth=growth, cutoff=cutoff, distance=distance, slipping=1.0)
    force = -dragged(contact, speed * step * np.arange(6000), step)
    law = A * math.exp(-B * speed) + C
    assert force[-1] == pytest.approx(law * (1 + growth * math.log1p(distance / speed / cutoff)), rel=1e-3)
    traction = Traction(limit=lambda rate, sense: STATIC, viscous=lambda rate, sense: 0.0)
    begun, _ = contact.initial(Approach(-2 * STATIC, speed, 0.0), traction)
    expected = STATIC * (1 + growth * math.log1p(1 / (speed / distance + 1 / cutoff) / cutoff))
    assert -float(begun) == pytest.approx(expected, rel=1e-6)


def test_what_ages_alike_in_stick_and_slip_is_renewed_by_what_its_spring_gives_way_to() -> None:
    """age' = 1 - |v| age/distance while the spring is wound up, from the age of the rest before."""
    step, rest, speed, growth, cutoff, distance = 1e-4, 2.0, 1e-3, 0.04, 0.01, 2e-5
    contact = contact_of("dwell_strengthening", growth=growth, cutoff=cutoff, distance=distance, slipping=1.0)
    force = -dragged(contact, speed * step * np.arange(2000), step, rest=rest)
    creeping = A * math.exp(-B * speed) + C
    expected = creeping
    for _ in range(8):
        renewed = expected / K1 / distance
        age = distance / speed + (rest - distance / speed) * math.exp(-renewed)
        expected = creeping * (1 + growth * math.log1p(age / cutoff))
    assert renewed > 3
    assert force.max() == pytest.approx(expected, rel=2e-3)


def test_the_age_at_the_start_is_that_of_the_start() -> None:
    """A mass that has rested breaks away later: the simulation hands the time of rest to the contact."""
    oscillator = with_effect(NOMINAL, "dwell_strengthening", growth=0.05)
    runs = [
        simulate(oscillator, samples=400, interval=1e-3, start=Start(before=Before(rest=rest)))
        for rest in (0.0, 100.0)
    ]
    first, second = (np.abs(np.asarray(run.force)).max() for run in runs)
    assert second > 1.1 * first


@pytest.mark.parametrize(("rest", "straight"), [(0.01, 0.0), (1.0, 0.0), (0.01, 0.5), (0.01, 1.0)])
def test_static_friction_is_lost_over_a_distance_and_is_back_after_any_stop(
    rest: float, straight: float
) -> None:
    """A slow pull, a stop of `rest` seconds, and the pull again: 1 + peak exp(-s/length) times the law, or
    along a parabola or a straight line that comes to an end."""
    step, speed, peak, length = 1e-3, 1e-3, 0.2, 5e-5
    pull = speed * step * np.arange(1, 601)
    path = np.concatenate([pull, np.full(round(rest / step), pull[-1]), pull[-1] - pull])
    contact = contact_of("slip_weakening", peak=peak, length=length, straight=straight)
    force = -dragged(contact, path, step)
    creeping = A * math.exp(-B * speed) + C
    for there, sense in ((force[:598], 1), (force[-598:], -1)):
        along = sense * there
        assert along.max() == pytest.approx(creeping * (1 + peak), rel=5e-3)
        slid = (np.arange(598) - np.argmax(along)) * speed * step
        beyond = slid > 0
        left = np.exp(-slid / length)
        if straight > 0:
            left = np.maximum(1 - straight * slid / length, 0.0) ** (1 / straight)
        expected = creeping * (1 + peak * left[beyond])
        np.testing.assert_allclose(along[beyond], expected, rtol=0.02 * peak)


@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_a_bristle_loses_its_peak_over_a_distance_however_fine_the_steps(step: float) -> None:
    """Slow sliding there and back on a contact that always gives way a little, beside its equations in steps
    of 10 us: z' = v (1 - alpha |z|/full), and the distance that tears grows with alpha |z|/full |v|."""
    speed, peak, length, fine = 1e-3, 0.2, 1e-4, 1e-5
    there = speed * step * np.arange(round(0.6 / step) + 1)
    path = np.concatenate([there, there[-2::-1]])
    contact = contact_of("slip_weakening", contact=SmoothContact(K1, 0.9), peak=peak, length=length)
    force = -dragged(contact, path, step)
    creeping = A * math.exp(-B * speed) + C
    z = torn = 0.0
    expected = [0.0]
    for number in range(round(1.2 / fine)):
        sense = 1.0 if number * fine < 0.6 else -1.0
        if number * fine == 0.6:
            torn = 0.0
        full = creeping * (1 + peak * math.exp(-torn / length)) / K1
        share = min(max((abs(z) / full - 0.9) / 0.1, 0.0), 1.0) if z * sense > 0 else 0.0
        plastic = (0.5 - 0.5 * math.cos(math.pi * share)) * abs(z) / full
        torn = torn + speed * fine * plastic if plastic > 0 else 0.0
        z += sense * speed * fine * (1 - plastic)
        expected.append(K1 * z)
    beside = np.array(expected)[:: round(step / fine)]
    assert np.abs(force[2:] - beside[2:]).max() < 0.05 * peak * creeping
    assert min(beside.max(), -beside.min()) > (1 + 0.5 * peak) * creeping


def test_a_mass_that_is_picked_up_in_slip_has_lost_what_it_has_slid() -> None:
    """At 2 mm/s, after 0.1 s the other way, for 40 ms more than its spring takes to be wound up from static
    friction there to that with the peak here: what is left at the start is that of 80 um."""
    winding = (2 + 0.2) * STATIC / K1 / 2e-3
    lags = np.linspace(0.0, 0.14 + winding, 2001)
    rates = Trace(lags, np.where(lags < 0.04 + winding, 2e-3, -2e-3))
    contact = contact_of("slip_weakening", peak=0.2, length=1e-4)
    traction = Traction(limit=lambda rate, sense: STATIC, viscous=lambda rate, sense: 0.0)

    def begun(approach: Approach) -> float:
        return -float(contact.initial(approach, traction)[0]) / STATIC - 1

    onward = Approach(-2 * STATIC, 2e-3, 0.0)
    assert begun(onward._replace(rates=rates)) == pytest.approx(0.2 * math.exp(-0.8), rel=0.02)
    assert begun(onward) == pytest.approx(0.0, abs=1e-12)
    assert begun(onward._replace(rate=0.0, rest=0.1)) == pytest.approx(0.2)


@pytest.mark.parametrize("contact", [LoadedContact(K1), SmoothContact(K1)])
def test_the_stuck_mass_rings_down_with_the_damping_of_the_contact(contact) -> None:
    """x = exp(-zeta w t) ..., w = sqrt(k1/m), 2 zeta w = damping/m, below a limit that is out of reach."""
    rig = dataclasses.replace(free(ExponentialFriction(0.0, 1.0, 1e6, 0.0)), contact=contact)
    omega = math.sqrt(K1 / 2.0)
    for zeta in (0.05, 0.4):
        damped = with_effect(rig, "contact_damping", damping=2 * zeta * omega * 2.0)
        run = simulate(damped, samples=300, interval=2e-4, start=Start(0.0, 0.01), steps_per_sample=20)
        ring = omega * math.sqrt(1 - zeta**2)
        t = np.asarray(run.time)
        expected = 0.01 / ring * np.exp(-zeta * omega * t) * np.sin(ring * t)
        assert np.abs(np.asarray(run.x) - expected).max() < 1e-3 * 0.01 / omega


def test_damping_that_is_all_loading_loses_what_the_integral_of_it_says() -> None:
    """From x = 0 at velocity v0 to the turning point the contact loses 2 d/F_s k1 x |v| dx, for weak damping
    2 d/F_s k1 v0^3/(3 w^2), and as much on the way back."""
    limit, speed, damping = 50.0, 0.01, 1.0
    rig = free(ExponentialFriction(0.0, 1.0, limit, 0.0))
    omega = math.sqrt(K1 / 2.0)
    assert K1 * speed / omega < limit
    run = simulate(
        with_effect(rig, "contact_damping", damping=damping, loading=1.0),
        samples=round(math.pi / omega / 1e-4) + 1,
        interval=1e-4,
        start=Start(0.0, speed),
        steps_per_sample=20,
    )
    lost = speed**2 - (np.asarray(run.v[-1]) ** 2 + omega**2 * np.asarray(run.x[-1]) ** 2)
    expected = 2 * 2 * damping / limit * K1 * speed**3 / (3 * omega**2)
    assert lost == pytest.approx(expected, rel=0.05)


def test_a_contact_without_dry_friction_is_not_damped() -> None:
    """It never sticks: the mass slides on at its own speed, whatever share of the damping is loading."""
    rig = with_effect(
        free(ExponentialFriction(0.0, 1.0, 0.0, 0.0)), "contact_damping", damping=5.0, loading=0.5
    )
    run = simulate(rig, samples=50, interval=1e-3, start=Start(0.0, 0.01))
    np.testing.assert_allclose(np.asarray(run.v), 0.01)


def test_no_damping_of_the_contact_is_too_much_for_a_step() -> None:
    rig = with_effect(free(ExponentialFriction(0.0, 1.0, 1e6, 0.0)), "contact_damping", damping=1e8)
    run = simulate(rig, samples=50, interval=1e-3, start=Start(0.0, 0.01), steps_per_sample=1)
    assert np.abs(np.asarray(run.x)).max() < 2e-5


def test_damping_of_the_contact_is_silent_in_slip() -> None:
    run = simulated(with_effect(NOMINAL, "contact_damping", damping=50.0))
    slip = slipping(run)
    assert np.abs(np.abs(run.force) - law(np.abs(run.v)))[slip].max() < 2e-3 * STATIC


def test_microslip_follows_masing_and_loses_the_area_of_its_loop() -> None:
    """Stiffness k1, then (1 - share) k1; full slip at g; between, a cycle loses 4 share k1 z (a - z)."""
    share, earlier, step = 0.4, 0.3, 1.0
    contact = contact_of("microslip", share=share, earlier=earlier)
    early = earlier * STATIC / K1
    full = (1 - share * earlier) / (1 - share) * STATIC / K1
    to, back = np.linspace(0, 0.9 * full, 4001), np.linspace(0.9 * full, -0.9 * full, 8001)
    path = np.concatenate([to, back[1:], -back[1:]])
    force = -dragged(contact, path, step)
    slope = np.diff(force) / np.diff(path) / K1
    assert slope[10] == pytest.approx(1, rel=1e-3)
    assert slope[3000] == pytest.approx(1 - share, rel=1e-3)
    reversal = len(to)
    assert slope[reversal + 10] == pytest.approx(1, rel=1e-3)
    elastic = np.argmax(slope[reversal:] < 1 - share / 2)
    assert path[reversal] - path[reversal + elastic] == pytest.approx(2 * early, rel=2e-3)
    cycle = slice(reversal, None)
    loss = np.trapezoid(force[cycle], path[cycle])
    assert loss == pytest.approx(4 * share * K1 * early * (0.9 * full - early), rel=1e-3)
    beyond = dragged(contact, np.linspace(0, 3 * full, 4000), step)
    assert -beyond[-1] == pytest.approx(A * math.exp(-B * 3 * full / 3999) + C, rel=1e-6)


def test_microslip_that_is_spread_bends_thrice() -> None:
    """The stiffness falls by a third of the share at each yield, on the way back at twice the deflection; a
    closed loop loses what three Jenkins elements do."""
    share, earlier, spread = 0.6, 0.4, 0.5
    contact = contact_of("microslip", share=share, earlier=earlier, spread=spread)
    yields = np.array([0.2, 0.4, 0.6]) * STATIC / K1
    far = 0.9 * STATIC / K1
    to, back = np.linspace(0, far, 4001), np.linspace(far, -far, 8001)
    path = np.concatenate([to, back[1:], -back[1:]])
    force = -dragged(contact, path, 1.0)
    slope = np.diff(force) / np.diff(path) / K1
    for begin, ends in ((0, yields), (len(to), 2 * yields)):
        for number, (low, high) in enumerate(itertools.pairwise([0.0, *ends, 2 * far if begin else far])):
            middle = begin + round(0.5 * (low + high) / far * 4000)
            assert slope[middle] == pytest.approx(1 - number * share / 3, rel=1e-3)
    cycle = slice(len(to), None)
    loss = sum(4 * share / 3 * K1 * z * (far - z) for z in yields)
    assert np.trapezoid(force[cycle], path[cycle]) == pytest.approx(loss, rel=1e-3)


@pytest.mark.parametrize("spread", [0.0, 0.5, 1.0])
def test_a_spread_contact_starts_on_the_branch_that_it_came_back_on(spread: float) -> None:
    """Dragged into slip and back by some way it holds a force; begun with this, it holds the deflections."""
    share, earlier = 0.5, 0.5
    oscillator = with_effect(free(LAW), "microslip", share=share, earlier=earlier, spread=spread)
    motion = oscillator.motion(0.0, oscillator.drive.at(0.0), 0.0, 0.0, 0.0)
    traction = oscillator.traction(None, motion)
    limit = earlier * (1 + spread * np.array([-1, 0, 1])) * STATIC / K1
    for back in np.array([0.1, 0.6, 1.1, 1.6]) * STATIC / K1:
        lost = K1 * (share * np.mean(np.minimum(back, 2 * limit)) + (1 - share) * back)
        held, (_, deflection) = oscillator.contact.initial(
            Approach(-(STATIC - lost), 0.0, 0.0, 1.0), traction
        )
        np.testing.assert_allclose(deflection, limit - np.minimum(back, 2 * limit), atol=1e-15)
        assert float(held) == pytest.approx(-(STATIC - lost))


def test_a_split_contact_rings_like_the_whole_at_a_coarse_step() -> None:
    """Below the early yield both elements are springs in parallel, k1 together: twelve steps a period."""
    rig = with_effect(free(LAW), "microslip", share=0.4, earlier=0.5)
    omega = math.sqrt(K1 / 2.0)
    step = 2 * math.pi / omega / 12
    run = simulate(rig, samples=120, interval=step, start=Start(0.0, 1e-3), steps_per_sample=1)
    expected = 1e-3 / omega * np.sin(omega * np.asarray(run.time))
    assert np.abs(np.asarray(run.x) - expected).max() < 0.06 * 1e-3 / omega


def test_microslip_starts_where_the_force_says() -> None:
    """A contact that holds a force holds it in both elements together, and stays at rest under it, whichever
    way it slid before."""
    oscillator = with_effect(free(LAW), "microslip", share=0.3, earlier=0.4)
    for force, slid in itertools.product((1.0, -5.0, STATIC), (-1.0, 0.0, 1.0)):
        motion = oscillator.motion(0.0, oscillator.drive.at(0.0), 0.0, 0.0, 0.0)
        traction = oscillator.traction(None, motion)
        held, _ = oscillator.contact.initial(Approach(force, 0.0, 0.0, slid), traction)
        assert float(held) == pytest.approx(force)


@pytest.mark.parametrize("slid", [-1.0, 1.0])
def test_the_early_element_remembers_the_sliding_before(slid: float) -> None:
    """From slip back by less or by more than twice its yield: it has gone back by as much, or yielded."""
    oscillator = with_effect(free(LAW), "microslip", share=0.3, earlier=0.4)
    motion = oscillator.motion(0.0, oscillator.drive.at(0.0), 0.0, 0.0, 0.0)
    traction = oscillator.traction(None, motion)
    early = 0.4 * STATIC / K1
    for back, expected in ((0.5 * early, 0.5 * early), (1.5 * early, -0.5 * early), (3.0 * early, -early)):
        lost = K1 * min(back, 2 * early) + 0.7 * K1 * max(back - 2 * early, 0.0)
        held, (_, deflection) = oscillator.contact.initial(
            Approach(-slid * (STATIC - lost), 0.0, 0.0, slid), traction
        )
        assert float(held) == pytest.approx(-slid * (STATIC - lost))
        np.testing.assert_allclose(deflection, slid * expected)


FRICTION = {
    "asymmetric_friction": {"dry": 0.05, "viscous": 0.2},
    "contact_damping": {"damping": 50.0},
    "dwell_strengthening": {"growth": 0.03},
    "friction_drift": {"rate": 5e-3},
    "frictional_memory": {"lag": 3e-3},
    "load_variation": {"in_phase": 0.03, "quadrature": 0.03},
    "microslip": {"share": 0.15},
    "periodic_track": {"cosine": 0.03, "sine": 0.03},
    "position_dependent_friction": {"gradient": 10.0},
    "slip_weakening": {"peak": 0.05},
    "stribeck_shape": {"excess": 0.3},
    "velocity_strengthening": {"growth": 0.02, "film": 0.5},
}


def travel(begin: float, samples: int = 400) -> OpenGrid:
    return open_grid(begin, 2e-3, samples, 4)


def test_friction_effects_attach_in_any_order() -> None:
    """All together: forwards and backwards give the same motion to a share of what they do."""
    effects = {key: replace(effects_at_null((key,))[key], values) for key, values in FRICTION.items()}
    ahead = behind = NOMINAL
    for key in effects:
        ahead = effects[key].attach(ahead)
    for key in reversed(effects):
        behind = effects[key].attach(behind)
    runs = (marched(oscillator, Start(), travel(0.0)) for oscillator in (ahead, behind, NOMINAL))
    one, other, without = (np.asarray(run.x) for run in runs)
    assert np.abs(one - other).max() < 0.05 * np.abs(one - without).max()


def test_what_grows_with_speed_sees_the_true_one_under_a_stribeck_curve_of_another_shape() -> None:
    """In whatever order the two are attached."""
    shaped = {
        "stribeck_shape": {"excess": 0.5, "reference": 0.01},
        "velocity_strengthening": {"growth": 0.05},
    }
    forces = []
    for keys in (tuple(shaped), tuple(reversed(shaped))):
        oscillator = NOMINAL
        for key in keys:
            oscillator = with_effect(oscillator, key, **shaped[key])
        forces.append(np.asarray(marched(oscillator, Start(), travel(0.0)).force))
    strengthening = with_effect(NOMINAL, "velocity_strengthening", growth=0.05)
    without = np.asarray(marched(strengthening, Start(), travel(0.0)).force)
    np.testing.assert_allclose(*forces, rtol=0, atol=1e-9 * STATIC)
    assert np.abs(forces[0] - without).max() > 0.01 * STATIC


def test_friction_effects_at_null_change_no_bit() -> None:
    together = NOMINAL
    for effect in effects_at_null(tuple(FRICTION)).values():
        together = effect.attach(together)
    runs = (marched(oscillator, Start(1e-3, 0.1, -2.0), travel(0.1)) for oscillator in (together, NOMINAL))
    for one, other in zip(*runs, strict=True):
        assert np.abs(np.asarray(one) - np.asarray(other)).max() <= 1e-13 * np.abs(np.asarray(other)).max()


def test_derivatives_at_null_with_all_friction_effects_attached() -> None:
    """By every strength together, from inside, against one-sided differences."""
    hypothesis = effects_at_null(tuple(FRICTION))
    names = [(key, name) for key, values in FRICTION.items() for name in values]
    sizes = np.array([FRICTION[key][name] for key, name in names])

    def motion(point):
        oscillator = NOMINAL
        for key in FRICTION:
            given = {name: point[i] for i, (owner, name) in enumerate(names) if owner == key}
            oscillator = replace(hypothesis[key], given).attach(oscillator)
        run = march(oscillator, Start(1e-3, 0.1, -2.0), travel(0.1, 250))
        seen = jnp.concatenate([run.displacement / 1e-2, run.friction / STATIC])
        return seen, seen

    slopes_and_motion = jax.jit(jax.jacfwd(motion, has_aux=True), compiler_options=QUICKLY)
    slopes, base = (np.asarray(part) for part in slopes_and_motion(jnp.zeros(len(names))))
    jacobian = slopes * sizes
    for index, (key, name) in enumerate(names):
        step = np.zeros(len(names))
        step[index] = 1e-5 * sizes[index]
        difference = (np.asarray(slopes_and_motion(jnp.asarray(step))[1]) - base) / 1e-5
        size = np.abs(jacobian[:, index]).max()
        assert size > 1e-4, (key, name)
        assert np.abs(difference - jacobian[:, index]).max() < 1e-3 * size, (key, name)
