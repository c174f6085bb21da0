"""The derivative of a function of a few numbers is that which plain differentiation finds."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.parts.by_few import by_few

RECORDED = {"ages": np.linspace(0.0, 1.0, 7), "values": np.array([3.0, -1.0, 2.0, 0.5, -2.0, 1.0, 4.0])}
NUMBERS = np.array([0.3, 2.0])


def faded(numbers: jax.Array, recorded: Any) -> jax.Array:
    time, power = numbers
    left = jnp.asarray(recorded["values"]) ** 2 * jnp.exp(-((recorded["ages"] / time) ** power))
    return jnp.stack([jnp.sum(left), left[0] * time])


def through(numbers: jax.Array, recorded: Any) -> jax.Array:
    return by_few(faded, numbers, recorded)


@pytest.mark.parametrize("by", [0, 1], ids=["by the numbers", "by what is recorded"])
@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev, lambda f, n: jax.jacfwd(jax.jacrev(f, n), n)])
def test_it_is_that_of_the_function(mode: Any, by: int) -> None:
    """First and second derivatives, forwards and backwards."""
    arguments = jnp.asarray(NUMBERS), jax.tree.map(jnp.asarray, RECORDED)
    found, expected = (mode(function, by)(*arguments) for function in (through, faded))
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-14), found, expected)


def test_both_change_at_once_in_lanes_and_compiled() -> None:
    """Along directions that move numbers and records together, in lanes that share a record, under jit."""
    lanes = jnp.asarray(np.array([[0.3, 2.0], [0.5, 1.0], [2.0, 3.0]]))
    record = jax.tree.map(jnp.asarray, RECORDED)

    def along(function: Any) -> Any:
        def one(numbers: jax.Array) -> Any:
            return jax.jvp(function, (numbers, record), (jnp.ones(2), jax.tree.map(jnp.cos, record)))

        return jax.jit(jax.vmap(one))(lanes)

    for found, expected in zip(along(through), along(faded), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


def test_directions_do_not_go_through_what_is_recorded() -> None:
    """With ten directions the program holds no array of ten times the record."""

    def in_ten_directions(function: Any) -> str:
        def along(direction: jax.Array) -> jax.Array:
            return jax.jvp(lambda n: function(n, RECORDED), (jnp.asarray(NUMBERS),), (direction,))[1]

        return str(jax.make_jaxpr(jax.vmap(along))(jnp.ones((10, 2))))

    assert "10,7]" in in_ten_directions(faded)
    assert "10,7]" not in in_ten_directions(through)
