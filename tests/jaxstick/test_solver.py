"""The oscillator inside diffrax, and the ways to run it side by side."""

from __future__ import annotations

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.oscillator import Flow, Oscillator, Start
from jaxstick.parameter import replace as with_values
from jaxstick.parts.contact import LoadedContact, PaperContact, SmoothContact
from jaxstick.parts.drive import RecordedDrive
from jaxstick.simulate import Grid, march, simulate
from jaxstick.solver import ReturnMapping, StickSlip
from tests.jaxstick.twin import twin
from tests.reference import rig1987

INTERVAL = 1e-3


def _paper_rig(contact: type = LoadedContact, ratio: float = 0.326) -> Oscillator:
    return twin(rig1987.rig(), rig1987.drive(ratio), contact)


@pytest.mark.parametrize("contact", [LoadedContact, PaperContact, SmoothContact])
def test_diffrax_solve_is_the_march(contact: type) -> None:
    """diffeqsolve with ReturnMapping visits the very states of `simulate`."""
    oscillator = _paper_rig(contact)
    samples = 400
    run = simulate(oscillator, samples=samples, interval=INTERVAL, steps_per_sample=1)
    state = jax.tree.map(jnp.asarray, oscillator.initial(jnp.asarray(0.0), Start()))
    solution = diffrax.diffeqsolve(
        StickSlip(oscillator),
        ReturnMapping(),
        t0=0.0,
        t1=INTERVAL * (samples - 1),
        dt0=INTERVAL,
        y0=state,
        saveat=diffrax.SaveAt(t0=True, steps=True),
        max_steps=samples + 1,
    )
    assert solution.ys is not None
    np.testing.assert_allclose(solution.ys.x[:samples], run.x, rtol=0, atol=1e-13)
    np.testing.assert_allclose(solution.ys.friction[:samples], run.force, rtol=0, atol=1e-8)


def test_derivative_through_a_diffrax_solve() -> None:
    """Reverse mode through diffeqsolve equals reverse mode through `march`."""
    oscillator = _paper_rig()
    samples = 300

    def by_diffrax(limit: jax.Array) -> jax.Array:
        changed = with_values(oscillator, {"C": limit})
        state = jax.tree.map(jnp.asarray, changed.initial(jnp.asarray(0.0), Start()))
        solution = diffrax.diffeqsolve(
            StickSlip(changed),
            ReturnMapping(),
            0.0,
            INTERVAL * (samples - 1),
            INTERVAL,
            state,
            max_steps=samples,
        )
        assert solution.ys is not None
        return solution.ys.x[-1]

    def by_march(limit: jax.Array) -> jax.Array:
        changed = with_values(oscillator, {"C": limit})
        return march(changed, Start(), Grid(0.0, INTERVAL, samples)).x[-1]

    limit = jnp.asarray(6.0)
    one, other = (float(jax.jit(jax.grad(by))(limit)) for by in (by_diffrax, by_march))
    assert one == pytest.approx(other, rel=1e-7)


def test_smooth_contact_is_a_differential_equation() -> None:
    """The bristle by Tsit5 through `vector_field` and by the return mapping give one motion."""
    oscillator = _paper_rig(SmoothContact)
    times = jnp.linspace(0.0, 1.0, 101)
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(oscillator.vector_field),  # pyright: ignore[reportArgumentType]
        diffrax.Tsit5(),
        0.0,
        1.0,
        1e-5,
        Flow(jnp.asarray(0.0), jnp.asarray(0.0), jnp.asarray(0.0)),
        saveat=diffrax.SaveAt(ts=times),
        stepsize_controller=diffrax.PIDController(rtol=1e-9, atol=1e-12),
        max_steps=200_000,
    )
    assert solution.ys is not None
    run = simulate(oscillator, samples=101, interval=0.01, steps_per_sample=1000)
    stroke = np.ptp(np.asarray(run.x))
    assert np.abs(np.asarray(solution.ys.x) - np.asarray(run.x)).max() < 1e-5 * stroke


def test_smooth_contact_tends_to_the_loaded_one() -> None:
    """As yielding begins ever closer to the limit."""
    loaded = np.asarray(simulate(_paper_rig(), samples=600, interval=INTERVAL).x)
    gaps = []
    for breakaway in (0.3, 0.7, 0.95):
        smooth = with_values(_paper_rig(SmoothContact), {"breakaway": breakaway})
        run = simulate(smooth, samples=600, interval=INTERVAL)
        gaps.append(np.abs(np.asarray(run.x) - loaded).max())
    assert gaps[0] > gaps[1] > gaps[2]
    assert gaps[2] < 5e-3 * np.ptp(loaded)


def test_hybrid_contact_has_no_vector_field() -> None:
    with pytest.raises(TypeError, match="ReturnMapping"):
        _paper_rig(PaperContact).vector_field(0.0, Flow(0.0, 0.0, 0.0))


def test_lanes_are_independent() -> None:
    """vmap over frequencies, amplitudes and constants gives what each lane gives alone."""
    base = _paper_rig()
    lanes = {
        "frequency": jnp.array([0.5, 1.5, 4.0]),
        "base_amplitude": jnp.array([8e-3, 1e-2, 3e-3]),
        "k1": jnp.array([3e4, 1e5, 4e5]),
    }

    def one(values: dict) -> jax.Array:
        return march(with_values(base, values), Start(), Grid(0.0, INTERVAL, 800, 2)).x

    together = jax.jit(jax.vmap(one))(lanes)
    for lane in range(3):
        alone = jax.jit(one)({name: value[lane] for name, value in lanes.items()})
        np.testing.assert_allclose(together[lane], alone, rtol=0, atol=1e-12)


def test_recorded_drive_replaces_the_sine() -> None:
    """A spline through 1 kHz samples of the base moves the mass as the sine does, to 1e-8 of the stroke."""
    sine = _paper_rig()
    times = INTERVAL * np.arange(1200)
    recorded = RecordedDrive.through(0.0, INTERVAL, base=np.asarray(sine.drive.at(jnp.asarray(times)).y))
    replaced = eqx.tree_at(lambda oscillator: oscillator.drive, sine, recorded)
    exact, ours = (
        simulate(o, samples=1200, interval=INTERVAL, steps_per_sample=4).x for o in (sine, replaced)
    )
    assert float(jnp.abs(ours - exact).max()) < 1e-8 * float(jnp.ptp(exact))


def test_phase_is_exact_however_long_the_record() -> None:
    """After a hundred thousand cycles the drive is where sin says, to 1e-9 of its amplitude."""
    oscillator = _paper_rig()
    frequency = 1.7
    drive = with_values(oscillator, {"frequency": frequency}).drive
    interval = 1 / (7.3 * frequency)
    times = interval * 730_000 + interval * jnp.arange(8.0)
    run = simulate(
        eqx.tree_at(lambda o: o.drive, oscillator, drive),
        samples=8,
        interval=interval,
        start_time=float(times[0]),
        steps_per_sample=10,
    )
    np.testing.assert_allclose(drive.at(run.time).y, drive.at(times).y, rtol=0, atol=1e-9 * 10.325e-3)


@pytest.mark.parametrize(("samples", "interval"), [(0, 1e-3), (10, 0.0), (10, -1.0)])
def test_simulate_refuses_what_it_cannot_mean(samples: int, interval: float) -> None:
    with pytest.raises(ValueError, match="must be positive"):
        simulate(_paper_rig(), samples=samples, interval=interval)


def test_recorded_drive_needs_samples() -> None:
    with pytest.raises(ValueError, match="base or of the force"):
        RecordedDrive.through(0.0, 1.0)
