"""What is kept is the value itself, in every derivative too, and the compiler leaves the division in."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.parts.kept import kept, kept_slope

VALUES = np.array([-3.0, -0.0, 0.0, 1e-300, 2.5, np.inf, -np.inf, np.nan])


@pytest.mark.parametrize("keep", [kept, kept_slope])
def test_the_value_is_the_same(keep):
    with jax.enable_x64(True):
        np.testing.assert_array_equal(jax.jit(keep)(VALUES), VALUES)
        np.testing.assert_array_equal(jax.vmap(keep)(VALUES), keep(VALUES))


@pytest.mark.parametrize("keep", [kept, kept_slope])
def test_derivatives_are_the_same_in_every_arrangement(keep):
    def through(x):
        return jnp.sin(keep(x * x)) * keep(x)

    def plain(x):
        return jnp.sin(x * x) * x

    with jax.enable_x64(True):
        x = jnp.array([0.3, -1.2, 2.0])
        for derive in (jax.grad, jax.jacfwd, jax.jacrev, lambda f: jax.grad(jax.grad(f))):
            np.testing.assert_allclose(
                jax.jit(jax.vmap(derive(through)))(x), jax.vmap(derive(plain))(x), rtol=1e-14
            )


@pytest.mark.parametrize("keep", [kept, kept_slope])
def test_the_compiler_keeps_one_division_for_every_direction_of_every_lane(keep):
    """Where the division is one by lane alone, it becomes a product, and is worked out again and again."""

    def along(direction, lanes):
        def function(x):
            many = keep(jnp.sin(x) * x)
            return many * x, many + x, x - many

        return jax.jvp(function, (lanes,), (direction * lanes,))[1]

    with jax.enable_x64(True):
        directions, lanes = jnp.arange(5.0), jnp.arange(1.0, 8.0)
        written = jax.jit(jax.vmap(along, (0, None))).lower(directions, lanes)
        program = written.compile({"xla_cpu_enable_fast_math": True}).as_text()
    assert program is not None and "f64[5,7]{1,0} divide(" in program
