"""The measuring chain against closed forms: filters, delays, play, resonance, and starts within a record."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.signal import lsim

from jaxstick.catalogue import catalogue
from jaxstick.nominal import nominal
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parameter import replace
from jaxstick.parts.before import Before
from jaxstick.parts.drive import RecordedDrive, SineDrive
from jaxstick.parts.instrument import AbstractInstrument, IdealInstrument, Past, Reading
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.track import Trace
from jaxstick.simulate import Grid, Trajectory, march
from tests.jaxstick.rig1987_runs import RIG, constants

NOMINAL = nominal(RIG, dataclasses.replace(constants(0.86), D=2.0), SineDrive(1.5, 10.325e-3))
STEP = 4e-4
STEPS = 2000
TIME = STEP * np.arange(STEPS + 1)
CREEPING = {"rate": 0.3, "time": 1.5, "tail": 1.0}
WARMING = {"rate": 0.3, "time": 0.2, "tail": 2.0}

Signal = Callable[[Any], Any]


def instrument(key: str, **values: Any) -> AbstractInstrument:
    """The instrument of a rig that has this effect only."""
    return replace(catalogue()[key](), values).attach(NOMINAL).instrument  # pyright: ignore[reportCallIssue]


def chain(inner: Oscillator, key: str, **values: Any) -> Oscillator:
    return replace(catalogue()[key](), values).attach(inner)  # pyright: ignore[reportCallIssue]


def moving(x: Signal) -> Callable[[Any], Motion]:
    """The motion of a mass at x(t) before a base at rest."""
    v = jax.grad(x)
    a = jax.grad(v)
    return lambda t: Motion(t, x(t), v(t), a(t), 0.0, 0.0, 0.0, 0.0, x(t), v(t), 1.0)


AT_REST = moving(lambda t: 0.0 * t)


class Record(NamedTuple):
    """What was read, one value a node."""

    displacement: np.ndarray
    friction: np.ndarray


def recorded(
    chain: AbstractInstrument,
    force: Signal,
    motion: Callable[[Any], Motion] = AT_REST,
    *,
    step: float = STEP,
    steps: int = STEPS,
    start: float = 0.0,
    past: Past | None = None,
) -> Record:
    """What the instrument reads of this force and motion, node by node from `start`.

    Numbers are arguments of the compiled program, also the frequency of a `sine`: one serves them all.
    """
    numbers = jax.tree.map(jnp.asarray, (chain, step, start, past))
    return Record(*map(np.asarray, _compiled(force, motion, steps, *numbers)))


def _recorded(
    force: Signal,
    motion: Callable[[Any], Motion],
    steps: int,
    chain: AbstractInstrument,
    step: Scalar,
    start: Scalar,
    past: Past | None,
) -> Reading:
    past = Past(jax.grad(force)(start)) if past is None else past
    begin = jax.tree.map(jnp.asarray, chain.initial(motion(start), force(start), past))

    def node(state: Any, number: Any) -> tuple[Any, Reading]:
        t = start + step * number
        state = chain.advance(state, motion(t), force(t), step)
        return state, chain.read(state, motion(t), force(t))

    _, later = jax.lax.scan(node, begin, jnp.arange(1.0, steps + 1.0))
    now = chain.read(begin, motion(start), force(start))
    return jax.tree.map(lambda a, b: jnp.concatenate([jnp.asarray(a)[None], b]), now, later)


_compiled = eqx.filter_jit(_recorded)


def _sine(frequency: Any, t: Any) -> Any:
    return jnp.sin(2 * jnp.pi * frequency * t)


def sine(frequency: float) -> Signal:
    return jax.tree_util.Partial(_sine, jnp.asarray(frequency))


def ramp(t: Any) -> Any:
    return 100.0 + 7.0 * t


def bumps(t: Any) -> Any:
    return jnp.sin(30.0 * t) + 2 * jnp.abs(jnp.sin(4.0 * t) - 0.4)


def response(reading: np.ndarray, frequency: float) -> complex:
    """Amplitude and phase of the second half of a reading at this frequency, relative to a sine."""
    half = slice(len(reading) // 2, None)
    angle = 2 * np.pi * frequency * TIME[half]
    basis = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    in_phase, ahead = np.linalg.lstsq(basis, reading[half], rcond=None)[0]
    return complex(in_phase, ahead)


@pytest.mark.parametrize("frequency", [5.0, 20.0, 80.0])
@pytest.mark.parametrize(
    ("curvature", "further"), [(0.0, 0.0), (0.25, 0.0), (0.5, 0.0), (0.25, 1 / 3), (0.5, 1.0)]
)
def test_the_lowpass_answers_a_sine_as_its_differential_equation_does(frequency, curvature, further):
    delay = 3e-3
    filtered = instrument("force_lowpass", time=delay, curvature=curvature, further=further)
    seen = recorded(filtered, sine(frequency)).friction
    s = 2j * np.pi * frequency
    first, last = (1 - further) * delay * s, further * delay * s
    expected = 1 / (1 + first + max(curvature, 1e-3) * first**2) / (1 + last)
    stages = 1 if further == 0.0 else 2
    off = stages * (2 * np.pi * frequency * STEP) ** 2 / 12
    assert abs(response(seen, frequency) / expected - 1) < 1e-3 + off


def test_the_lowpass_with_one_stage_relaxes_exponentially():
    after_edge = recorded(
        instrument("force_lowpass", time=5e-3, curvature=0.0),
        lambda t: jnp.where(t > STEP / 2, 1.0, 0.0),
        past=Past(),
    ).friction
    expected = 1 - np.exp(-(TIME - STEP / 2) / 5e-3)
    assert np.max(np.abs(after_edge - expected)[5:]) < 2e-3


@pytest.mark.parametrize("step", [1e-6, 1e-4, 1e-2, 1.0])
def test_no_step_is_too_long_or_too_short_for_a_lag(step):
    """Behind a ramp every lag settles at ramp less slope times its delay."""
    for key, values, delay in (
        ("force_lowpass", {"time": 2e-3, "curvature": 0.5}, 2e-3),
        ("force_lowpass", {"time": 2e-3, "curvature": 0.5, "further": 0.4}, 2e-3),
        ("force_table_compliance", {"share": 1.0, "damping": 0.3}, 2 * 0.3 / (2 * math.pi * 46.0)),
    ):
        seen = recorded(instrument(key, **values), ramp, step=step, steps=300, past=Past(7.0))
        expected = ramp(step * np.arange(301)) - 7.0 * delay
        np.testing.assert_allclose(seen.friction, expected, rtol=1e-9)


@pytest.mark.parametrize("key", ["force_lowpass", "force_delay"])
def test_the_first_order_effect_of_lateness_is_the_rate_of_the_force(key):
    name = {"force_lowpass": "time", "force_delay": "delay"}[key]

    def force(t):
        return jnp.sin(9.0 * t) + jnp.abs(t - 0.3)

    @jax.jit
    def reading(late):
        chain = instrument(key, **{name: late})
        state = chain.initial(AT_REST(0.0), force(0.0), Past(9.0 - 1.0))
        out = [chain.read(state, AT_REST(0.0), force(0.0)).friction]
        for number in range(1, 4):
            t = number * 1e-3
            state = chain.advance(state, AT_REST(t), force(t), 1e-3)
            out.append(chain.read(state, AT_REST(t), force(t)).friction)
        return jnp.stack([jnp.asarray(value) for value in out])

    value, slope = jax.jvp(reading, (jnp.asarray(0.0),), (jnp.asarray(1.0),))
    truth = np.asarray(force(1e-3 * np.arange(4)))
    np.testing.assert_allclose(value, truth, atol=1e-14)
    np.testing.assert_allclose(slope, [-8.0, *-np.diff(truth) / 1e-3], rtol=1e-9)
    tiny = np.asarray(reading(jnp.asarray(1e-9)) - value) / 1e-9
    np.testing.assert_allclose(tiny, slope, rtol=1e-4)


@pytest.mark.parametrize("late", [0.3e-3, 2e-3, 11.1e-3, 20e-3])
def test_the_delayed_force_is_the_force_shifted(late):
    seen = recorded(instrument("force_delay", delay=late), bumps, past=Past(30.0 - 8.0)).friction
    truth = np.asarray(bumps(TIME - late))
    inside = late <= TIME
    assert np.max(np.abs(seen - truth)[inside]) < 16 * STEP / 4
    smooth = inside & (np.abs(np.sin(4.0 * (TIME - late)) - 0.4) > 0.01)
    assert np.max(np.abs(seen - truth)[smooth]) < 3e-5
    before = late > TIME
    np.testing.assert_allclose(
        seen[before], 0.8 + np.clip(22.0 * (TIME - late), -0.8, 0.8)[before], atol=1e-12
    )


@pytest.mark.parametrize("late", [190.2 * STEP, 0.31, 0.779])
def test_a_delay_of_many_steps_is_no_shorter_for_that(late):
    seen = recorded(instrument("force_delay", delay=late), sine(0.8)).friction
    inside = late <= TIME
    np.testing.assert_allclose(seen[inside], np.sin(1.6 * np.pi * (TIME - late))[inside], atol=2e-4)


def test_the_delayed_force_is_smooth_in_the_delay():
    delays = jnp.linspace(1.0e-3, 3.0e-3, 41)
    force = sine(8.0)

    @jax.jit
    @jax.vmap
    def last(delay: Any) -> Any:
        chain = instrument("force_delay", delay=delay)
        seen = _recorded(force, AT_REST, 100, chain, jnp.asarray(STEP), jnp.asarray(0.0), Past())
        return jnp.asarray(seen.friction)[-1]

    slopes = np.diff(last(delays)) / np.diff(delays)
    middles = jnp.asarray((delays[1:] + delays[:-1]) / 2)
    np.testing.assert_allclose(slopes, -jax.vmap(jax.grad(force))(100 * STEP - middles), rtol=0.03)


def test_the_highpass_answers_a_sine_as_its_differential_equation_does():
    corner, frequency = 0.4, 5.0
    leak = 2 * np.pi * corner
    seen = recorded(instrument("force_highpass", corner=corner), sine(frequency)).friction
    s = 2j * np.pi * frequency
    angle = 2 * np.pi * frequency * TIME
    periodic = np.imag(s / (s + leak) * np.exp(1j * angle))
    decaying = np.exp(-leak * TIME) * (0 - periodic[0])
    np.testing.assert_allclose(seen, periodic + decaying, atol=1e-4)


@pytest.mark.parametrize("second", [0.25, 0.5])
def test_two_stages_of_highpass_are_the_linear_system_of_their_equation(second):
    corner, frequency = 0.4, 5.0
    leak = 2 * np.pi * corner
    seen = recorded(instrument("force_highpass", corner=corner, second=second), sine(frequency)).friction
    entering = np.sin(2 * np.pi * frequency * TIME)
    _, expected, _ = lsim(([1, 0, 0], [1, leak, second * leak**2]), entering, TIME)
    np.testing.assert_allclose(seen, expected, atol=1e-5)


@pytest.mark.parametrize(("second", "held"), [(0.0, 0.0), (0.5, 0.0), (0.5, -0.6)])
def test_the_highpass_goes_on_from_the_impulse_of_the_record(second, held):
    force = sine(1.3)
    chain = instrument("force_highpass", corner=0.2, before=0.2, held=held, second=second)
    whole = recorded(chain, force).friction
    middle = 700
    impulse = cumulative_trapezoid(whole, dx=STEP, initial=0.0)
    impulse_sum = cumulative_trapezoid(impulse, dx=STEP, initial=0.0)
    past = Past(0.0, Before(impulse=float(impulse[middle]), impulse_sum=float(impulse_sum[middle])))
    rest = recorded(chain, force, start=float(TIME[middle]), steps=STEPS - middle, past=past).friction
    np.testing.assert_allclose(rest, whole[middle:], atol=1e-6)
    assert np.max(np.abs(recorded(chain, force, start=float(TIME[middle])).friction[0] - whole[middle])) > 0.1


def test_two_stages_forget_what_they_had_lost_when_the_run_began():
    """With no force f'' + w f' + second w^2 f = 0, from f = -before and f' = w before - second w (before +
    held)."""
    corner, second, before, held = 0.4, 0.5, 0.7, -0.3
    leak = 2 * np.pi * corner
    apart = [
        recorded(instrument("force_highpass", corner=corner, second=second, **lost), sine(1.3)).friction
        for lost in ({"before": before, "held": held}, {})
    ]
    begin = [-before, leak * before - second * leak * (before + held)]
    system = [[0.0, 1.0], [-second * leak**2, -leak]], [[0.0], [0.0]], [[1.0, 0.0]], [[0.0]]
    _, expected, _ = lsim(system, np.zeros(len(TIME)), TIME, X0=begin)
    np.testing.assert_allclose(apart[0] - apart[1], expected, atol=1e-5)
    assert np.abs(expected).max() > 0.5


def test_what_the_highpass_lost_before_the_run_comes_back_as_it_forgets():
    corner, before = 0.4, 0.7
    apart = [
        recorded(instrument("force_highpass", corner=corner, before=lost), sine(1.3)).friction
        for lost in (before, 0.0)
    ]
    np.testing.assert_allclose(apart[0] - apart[1], -before * np.exp(-2 * np.pi * corner * TIME), atol=1e-5)


@pytest.mark.parametrize("spread", [0.0, 0.5, 1.0])
def test_the_hysteresis_is_the_mean_of_play_operators(spread):
    width, steps = 0.3, 400
    walk = jnp.asarray(np.cumsum(np.random.default_rng(3).standard_normal(steps + 1)) * 0.2)
    seen = recorded(
        instrument("force_hysteresis", width=width, spread=spread),
        lambda t: walk[jnp.round(t).astype(int)],
        step=1.0,
        steps=steps,
        past=Past(1.0),
    ).friction
    widths = width * (1 + spread * np.array([-0.8, -0.4, 0.0, 0.4, 0.8]))
    plays = [float(walk[0]) - widths]
    for value in np.asarray(walk)[1:]:
        plays.append(np.clip(plays[-1], value - widths, value + widths))
    np.testing.assert_allclose(seen, np.mean(plays, axis=1), atol=1e-12)


def test_plays_begin_where_the_recorded_force_is():
    known = Past(1.0, Before(recorded=1.1))
    seen = recorded(instrument("force_hysteresis", width=0.3, spread=0.5), lambda t: 1.0 + t, past=known)
    assert float(seen.friction[0]) == pytest.approx(1.1, abs=1e-9)


def test_the_loop_of_the_hysteresis_has_the_area_of_a_parallelogram():
    width = 0.2
    seen = recorded(instrument("force_hysteresis", width=width), sine(1.25)).friction
    cycle = slice(0, STEPS + 1)
    entering = np.sin(2 * np.pi * 1.25 * TIME)
    area = np.trapezoid(seen[cycle], entering[cycle])
    assert abs(area) == pytest.approx(4 * width * (1 - width), rel=1e-3)


@pytest.mark.parametrize("share", [0.5, 1.0])
@pytest.mark.parametrize("frequency", [5.0, 35.0, 46.0, 60.0, 150.0])
def test_the_table_answers_a_sine_as_a_mass_on_springs(frequency, share):
    damping = 0.1
    seen = recorded(
        instrument("force_table_compliance", share=share, damping=damping), sine(frequency)
    ).friction
    ratio = frequency / 46.0
    expected = 1 - share + share / (1 - ratio**2 + 2j * damping * ratio)
    assert abs(response(seen, frequency) - expected) < 0.012


def test_the_table_overshoots_an_edge_and_rings_at_its_frequency():
    damping = 0.05
    seen = recorded(
        instrument("force_table_compliance", share=1.0, damping=damping),
        lambda t: jnp.where(t > STEP / 2, 1.0, 0.0),
        past=Past(),
    ).friction
    assert np.max(seen) - 1 == pytest.approx(
        math.exp(-math.pi * damping / math.sqrt(1 - damping**2)), abs=5e-3
    )
    crossings = TIME[1:][np.diff(np.sign(seen - 1)) != 0]
    period = 2 * np.mean(np.diff(crossings[:12]))
    assert 1 / period == pytest.approx(46.0 * math.sqrt(1 - damping**2), rel=5e-3)


def test_the_clipped_force_keeps_a_share_above_the_level():
    def force(t):
        return 10 * jnp.sin(9.0 * t)

    entering = np.asarray(force(TIME))
    beyond = np.sign(entering) * np.maximum(np.abs(entering) - 6.0, 0.0)
    half = recorded(instrument("force_clipping", cut=0.5, level=6.0), force).friction
    np.testing.assert_allclose(half, entering - 0.5 * beyond, atol=1e-8)
    hard = recorded(instrument("force_clipping", cut=1.0, level=6.0), force).friction
    assert np.max(np.abs(hard)) == pytest.approx(6.0)


def test_a_channel_that_clips_softly_flattens_forces_below_the_level_too():
    def force(t):
        return 10 * jnp.sin(9.0 * t)

    entering = np.asarray(force(TIME))
    soft = recorded(instrument("force_clipping", cut=0.8, level=6.0, softness=0.5), force).friction
    clipped = entering / np.sqrt(1 + (entering / 6.0) ** 2)
    np.testing.assert_allclose(soft, entering - 0.8 * (entering - clipped), atol=1e-6)


HARMONICS = {"second_even": 0.3, "second_odd": -0.4, "third_even": -0.2, "third_odd": 0.1}


def hum(phase, size):
    """A hum with a second and a third harmonic that keep step with it."""
    second = 0.3 * np.cos(2 * phase) - 0.4 * np.sin(2 * phase)
    third = -0.2 * np.cos(3 * phase) + 0.1 * np.sin(3 * phase)
    return size * (np.cos(phase) + second + third)


@pytest.mark.parametrize(
    ("key", "values", "expected"),
    [
        ("force_gain", {"gain": 0.05}, lambda t, x, v, a, f: 1.05 * f),
        ("force_gain", {"gain": 0.05, "bend": -0.1}, lambda t, x, v, a, f: f + 0.05 * f * (1 - 0.1 * abs(f))),
        ("force_offset", {"offset": 0.4}, lambda t, x, v, a, f: f + 0.4),
        ("force_drift", {"rate": 0.3}, lambda t, x, v, a, f: f + 0.3 * t),
        ("force_drift", {"rate": 0.3, "time": 1.5}, lambda t, x, v, a, f: f + 0.45 * (1 - np.exp(-t / 1.5))),
        ("force_drift", CREEPING, lambda t, x, v, a, f: f + 0.45 * np.log1p(t / 1.5)),
        ("force_drift", WARMING, lambda t, x, v, a, f: f + 0.06 * (np.sqrt(1 + 2 * t / 0.2) - 1)),
        ("force_inertia", {"mass": 0.1}, lambda t, x, v, a, f: f + 0.1 * a),
        ("force_position_crosstalk", {"slope": 30.0}, lambda t, x, v, a, f: f + 30.0 * x),
        (
            "force_position_crosstalk",
            {"slope": 30.0, "bend": 50.0},
            lambda t, x, v, a, f: f + 30.0 * x * (1 + 50.0 * abs(x)),
        ),
        (
            "mains_hum",
            {"cosine": 0.1, "sine": 0.2, "frequency": 50.0},
            lambda t, x, v, a, f: f + 0.1 * np.cos(100 * np.pi * t) + 0.2 * np.sin(100 * np.pi * t),
        ),
        (
            "mains_hum",
            {"cosine": 0.1, "sine": 0.2, "frequency": 50.0} | HARMONICS,
            lambda t, x, v, a, f: f + hum(100 * np.pi * t - math.atan2(0.2, 0.1), math.hypot(0.1, 0.2)),
        ),
    ],
)
def test_what_has_no_memory_reads_its_formula(key, values, expected):
    motion = moving(lambda t: 0.01 * jnp.sin(7.0 * t))
    force = sine(3.0)
    seen = recorded(instrument(key, **values), force, motion, start=2.0, steps=300)
    t = 2.0 + TIME[:301]
    at = jax.vmap(motion)(jnp.asarray(t))
    x, v, a = (np.asarray(part) for part in (at.x, at.v, at.a))
    np.testing.assert_allclose(seen.friction, expected(t, x, v, a, np.asarray(force(t))), atol=1e-12)
    np.testing.assert_allclose(seen.displacement, x, atol=1e-15)


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("force_gain", {"gain": 0.05, "bend": -0.1}),
        ("force_position_crosstalk", {"slope": 30.0, "bend": 50.0}),
    ],
)
def test_a_scale_bends_alike_on_both_sides(key, values):
    wave = sine(3.0)
    to, fro = (
        recorded(
            instrument(key, **values),
            lambda t, side=side: side * wave(t),
            moving(lambda t, side=side: side * 0.01 * jnp.sin(7.0 * t)),
        ).friction
        for side in (1.0, -1.0)
    )
    np.testing.assert_allclose(fro, -to, atol=1e-12)


@pytest.mark.parametrize("bend", [0.0, -40.0])
def test_the_displacement_is_scaled(bend):
    motion = moving(lambda t: 0.01 * jnp.sin(7.0 * t))
    seen = recorded(instrument("displacement_gain", gain=0.02, bend=bend), sine(3.0), motion)
    x = 0.01 * np.sin(7.0 * TIME)
    np.testing.assert_allclose(seen.displacement, x + 0.02 * x * (1 + bend * np.abs(x)), atol=1e-15)
    np.testing.assert_allclose(seen.friction, np.asarray(sine(3.0)(TIME)), atol=1e-15)


def test_the_displacement_is_late_to_third_order():
    motion = moving(lambda t: jnp.sin(20.0 * t))

    def error(late):
        seen = recorded(instrument("displacement_delay", delay=late), sine(3.0), motion, step=1e-4)
        times = 1e-4 * np.arange(STEPS + 1)
        return np.max(np.abs(seen.displacement - np.sin(20.0 * (times - late)))[400:])

    near, far = error(5e-3), error(10e-3)
    assert near < (20.0 * 5e-3) ** 4 / 20
    assert 12 < far / near < 20


def test_the_late_displacement_after_a_jump_of_the_acceleration_stays_within_its_bound():
    late, jump, when = 4e-3, 3.0, 0.1

    def x(t):
        return jump / 2 * jnp.maximum(t - when, 0.0) ** 2

    def motion(t):
        after = jnp.where(t >= when, 1.0, 0.0)
        return AT_REST(t)._replace(x=x(t), v=jump * jnp.maximum(t - when, 0.0), a=jump * after)

    times = 1e-5 * np.arange(20001)
    seen = recorded(instrument("displacement_delay", delay=late), sine(3.0), motion, step=1e-5, steps=20000)
    error = np.max(np.abs(seen.displacement - np.asarray(x(times - late))))
    assert 0.97 < error / (late**2 * jump / 21.86) < 1.03


def test_gain_and_delay_of_the_displacement_act_on_the_same_reading_in_either_order():
    motion = moving(lambda t: 0.01 * jnp.sin(7.0 * t))
    one = chain(chain(NOMINAL, "displacement_gain", gain=0.1), "displacement_delay", delay=3e-3)
    other = chain(chain(NOMINAL, "displacement_delay", delay=3e-3), "displacement_gain", gain=0.1)
    seen = [recorded(each.instrument, sine(3.0), motion) for each in (one, other)]
    np.testing.assert_allclose(seen[0].displacement, seen[1].displacement, atol=1e-15)
    np.testing.assert_allclose(seen[0].friction, seen[1].friction, atol=1e-15)


GRID = Grid(0.0, 2e-3, 400, 5)


marched = jax.jit(march)


def travelled(oscillator: Oscillator) -> Trajectory:
    run = marched(jax.tree.map(jnp.asarray, oscillator), Start(), GRID)
    return jax.tree.map(np.asarray, run)


def test_a_late_base_is_a_drive_ahead_of_its_record():
    late, omega = 3e-3, 2 * np.pi * 1.5
    seen = travelled(chain(NOMINAL, "base_delay", delay=late))
    ahead = travelled(dataclasses.replace(NOMINAL, drive=SineDrive(1.5, 10.325e-3, phase=omega * late)))
    np.testing.assert_allclose(seen.displacement, ahead.displacement, atol=1e-12)


@pytest.mark.parametrize("rounded", [0.3, 1.0])
def test_a_filtered_base_is_larger_than_its_record_and_ahead_of_it(rounded):
    """As 1 + i omega lag says, with all its derivatives."""
    delay, omega = 30e-3, 2 * np.pi * 1.5
    lag = rounded * delay
    ahead = omega * (delay - lag) + np.arctan(omega * lag)
    true = SineDrive(1.5, 10.325e-3 * np.hypot(1.0, omega * lag), phase=ahead)
    seen = chain(NOMINAL, "base_delay", delay=delay, rounded=rounded).drive.at(TIME)
    for part, expected in zip(seen[:3], true.at(TIME)[:3], strict=True):
        np.testing.assert_allclose(part, expected, atol=1e-9 * np.max(np.abs(expected)))


def test_a_late_base_acts_alike_on_a_sine_and_on_its_record():
    times = 2e-3 * np.arange(401)
    record = RecordedDrive.through(0.0, 2e-3, 10.325e-3 * np.sin(2 * np.pi * 1.5 * times))
    for late in (3e-3, -3e-3):
        sine_driven = travelled(chain(NOMINAL, "base_delay", delay=late))
        as_recorded = travelled(chain(dataclasses.replace(NOMINAL, drive=record), "base_delay", delay=late))
        np.testing.assert_allclose(as_recorded.displacement, sine_driven.displacement, atol=2e-7)


def test_the_applied_force_is_neither_late_nor_scaled_with_the_base():
    drive = SineDrive(1.5, 10e-3, 3.0)
    pushed = dataclasses.replace(NOMINAL, drive=drive)
    for key, name in (("base_delay", "delay"), ("base_gain", "gain")):
        seen = chain(pushed, key, **{name: 0.05}).drive.at(TIME)
        np.testing.assert_allclose(seen.u, drive.at(TIME).u)
        assert np.max(np.abs(seen.y - drive.at(TIME).y)) > 3e-4


def test_the_true_base_is_the_recorded_one_over_the_gain():
    seen = chain(NOMINAL, "base_gain", gain=0.25).drive.at(TIME)
    for part, true in zip(seen[:3], NOMINAL.drive.at(TIME)[:3], strict=True):
        np.testing.assert_allclose(part, true / 1.25)


@pytest.mark.parametrize("bend", [-30.0, 40.0])
def test_a_base_whose_scale_bends_is_the_recorded_one_over_the_scale_at_it(bend):
    gain, step = 0.2, 1e-5
    drive = chain(NOMINAL, "base_gain", gain=gain, bend=bend).drive
    recorded, seen = NOMINAL.drive.at(TIME).y, drive.at(TIME)
    np.testing.assert_allclose(seen.y * (1 + gain * (1 + bend * np.abs(recorded))), recorded, atol=1e-15)
    before, after = drive.at(TIME - step), drive.at(TIME + step)
    away = np.abs(recorded) > 1e-4
    np.testing.assert_allclose(((after.y - before.y) / (2 * step))[away], seen.y_rate[away], atol=1e-7)
    bent = (after.y_rate - before.y_rate) / (2 * step)
    np.testing.assert_allclose(bent[away], seen.y_acceleration[away], atol=1e-5)


def test_without_the_force_a_gain_of_the_displacement_is_one_of_the_base():
    """m (g x)'' + c (g x)' + K (g x) = k_d (g y) + g F(g v / g): the motion as read is that of a rig with
    g times the base and friction g A, B/g, g C, D."""
    gain, stated = 1.25, dataclasses.replace(constants(0.86), D=2.0)
    scaled = dataclasses.replace(stated, A=gain * 7.47 * 0.14, B=100.0 / gain, C=gain * 7.47 * 0.86)
    read = travelled(chain(NOMINAL, "displacement_gain", gain=gain - 1))
    rescaled = nominal(RIG, scaled, NOMINAL.drive)
    moved = travelled(chain(rescaled, "base_gain", gain=1 / gain - 1))
    np.testing.assert_allclose(moved.displacement, read.displacement, atol=1e-12)
    np.testing.assert_allclose(moved.friction, gain * read.friction, atol=1e-9)
    one, other = catalogue()["displacement_gain"], catalogue()["base_gain"]
    assert one.traces_in_motion == other.traces and not {*one.traces} & {*other.traces}


class _RateMeter(AbstractInstrument):
    """Reads the rate of the friction force and the acceleration as told at the start."""

    def initial(self, motion: Motion, friction: Scalar, past: Past) -> Any:
        return past.rate, motion.a

    def read(self, state: Any, motion: Motion, friction: Scalar) -> Reading:
        return Reading(state[1], state[0])


def test_an_instrument_is_told_acceleration_and_rate_of_the_force_at_the_start():
    oscillator = dataclasses.replace(NOMINAL, instrument=_RateMeter())
    law, k1 = oscillator.friction, oscillator.contact.k1

    def told(start):
        seen = marched(oscillator, start, Grid(0.1, 2e-3, 1, 1))
        return float(seen.friction[0]), float(seen.displacement[0])

    rate, acceleration = told(Start(1e-3, 2e-3, -3.0))
    assert rate == pytest.approx(-float(k1) * 2e-3, rel=1e-3)
    base = 10.325e-3 * np.sin(2 * np.pi * 1.5 * 0.1)
    assert acceleration == pytest.approx((1986 * (base - 1e-3) - 4.53 * 2e-3 - 3.0) / 2.38)
    rate, acceleration = told(Start(1e-3, 0.05, -7.0))
    slope = law.A * law.B * np.exp(-law.B * 0.05) - law.D  # pyright: ignore[reportAttributeAccessIssue]
    assert rate == pytest.approx(slope * acceleration, rel=2e-2)


@jax.jit
@functools.partial(jax.vmap, in_axes=(None, 0, 0))
def segments(oscillator: Oscillator, start: Start, time: Any) -> Trajectory:
    return march(oscillator, start, Grid(time, 2e-3, 25, 5))


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("force_delay", {"delay": 2e-3}),
        ("force_lowpass", {"time": 2e-3, "curvature": 0.3}),
        ("force_lowpass", {"time": 2e-3, "curvature": 0.3, "further": 0.5}),
        ("displacement_delay", {"delay": 2e-3}),
        ("force_hysteresis", {"width": 0.1}),
    ],
)
def test_a_segment_taken_from_a_record_begins_as_the_record_goes_on(key, values):
    """What the effect does to the readings of segments of 50 ms picked up here and there in a run, against
    what it does to the whole run."""
    oscillator = chain(NOMINAL, key, **values)
    whole = travelled(oscillator)
    firsts = np.arange(20, 370, 7)

    before = Before(recorded=whole.friction[firsts])
    first = Start(whole.x[firsts], whole.v[firsts], whole.force[firsts], before)
    first = jax.tree.map(lambda part: np.broadcast_to(np.asarray(part, float), firsts.shape), first)
    seen = segments(oscillator, first, 2e-3 * firsts)

    def done(run: Trajectory) -> np.ndarray:
        return np.stack([(run.displacement - run.x) / 1e-5, (run.friction - run.force) / 0.06])

    samples = firsts[:, None] + np.arange(25)
    expected = done(whole)[:, samples]
    assert np.sqrt(np.mean(expected**2)) > 0.9
    assert np.sqrt(np.mean((done(seen) - expected) ** 2)) < 0.1 * np.sqrt(np.mean(expected**2))


def test_a_table_rings_on_where_a_segment_is_picked_up():
    """A stretch of a record, long after the beginning of which it still rings, from what it showed before."""
    oscillator = chain(NOMINAL, "force_table_compliance", share=0.3, frequency=20.0, damping=0.05, second=0.2)
    whole = travelled(oscillator)
    wrong = []
    for first in range(120, 360, 20):
        unshown = Before(recorded=whole.friction[first])
        trace = Trace(2e-3 * np.arange(96), whole.friction[first - np.arange(96)])
        begin = Start(whole.x[first], whole.v[first], whole.force[first], unshown)
        known = begin._replace(before=unshown._replace(shown=trace))
        runs = [marched(oscillator, each, Grid(2e-3 * first, 2e-3, 25, 5)) for each in (begin, known)]
        wrong.append([run.friction - whole.friction[first : first + 25] for run in runs])
    blind, seeing = np.sqrt(np.mean(np.square(wrong), axis=(0, 2)))
    assert seeing < 0.35 * blind


def test_the_ideal_instrument_needs_no_past():
    assert IdealInstrument().initial(AT_REST(0.0), 1.0, Past()) is None
