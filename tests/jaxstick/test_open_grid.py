"""A grid whose number of steps is told when the program runs."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.oscillator import Start
from jaxstick.parameter import replace as with_values
from jaxstick.simulate import Grid, OpenGrid, march
from tests.jaxstick.twin import twin
from tests.reference import rig1987

SAMPLES, INTERVAL = 120, 2e-3
OSCILLATOR = twin(rig1987.rig(), rig1987.drive(0.25))


@jax.jit
def _moved(C: jax.Array, grid: Grid | OpenGrid) -> jax.Array:
    run = march(with_values(OSCILLATOR, {"C": C}), Start(1e-3, 0.05, -2.0), grid)
    return jnp.stack([1e3 * run.displacement, run.friction])


_slope = jax.jit(jax.jacfwd(_moved))


@pytest.mark.parametrize("substeps", [1, 2, 7])
def test_motion_and_forward_derivative_are_those_of_a_fixed_grid(substeps: int):
    open_grid = OpenGrid(0.0, INTERVAL, jnp.asarray(substeps), jnp.asarray(SAMPLES), SAMPLES + 40)
    fixed = Grid(0.0, INTERVAL, SAMPLES, substeps)
    for of in (_moved, _slope):
        found, wanted = (of(jnp.asarray(6.0), grid) for grid in (open_grid, fixed))
        assert np.abs(wanted).max() > 0.1
        np.testing.assert_allclose(found[:, :SAMPLES], wanted, rtol=1e-9, atol=1e-9)
        assert not found[:, SAMPLES:].any()


def test_one_program_serves_every_step_and_any_number_of_samples():
    traced = []

    @jax.jit
    def moved(steps: jax.Array, reach: jax.Array) -> jax.Array:
        traced.append(steps)
        return _moved(jnp.asarray(6.0), OpenGrid(0.0, INTERVAL, steps, reach, SAMPLES))

    coarse, fine, short = (
        moved(jnp.asarray(n), jnp.asarray(m)) for n, m in ((4, SAMPLES), (16, SAMPLES), (16, 50))
    )
    assert len(traced) == 1
    assert 0 < np.abs(coarse - fine).max() < 0.2
    np.testing.assert_array_equal(short[:, :50], fine[:, :50])
