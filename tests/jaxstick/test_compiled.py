"""Programs over lanes: packs, threads, compiler options, Jacobians by rows of lanes."""

from __future__ import annotations

import threading

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.compiled import WIDTH, compiled, in_packs, lane_jacobian


def _square(lanes: dict[str, jax.Array], factor: jax.Array) -> dict[str, jax.Array]:
    return {"sum": lanes["a"] + factor * lanes["b"][:, 0], "whole": lanes["b"] ** 2}


@pytest.mark.parametrize("count", [1, 2, 7, 8, 23])
@pytest.mark.parametrize("workers", [1, 2, 3])
def test_packs_give_what_the_whole_gives(count: int, workers: int) -> None:
    """For any number of lanes and workers, whether or not the last pack is full."""
    lanes = {"a": np.arange(float(count)), "b": np.arange(2.0 * count).reshape(count, 2)}
    factor = jnp.asarray(3.0)
    whole = _square(jax.tree.map(jnp.asarray, lanes), factor)
    found = in_packs(compiled(_square), lanes, factor, pack=4, workers=workers)
    assert {name: leaf.shape for name, leaf in found.items()} == {"sum": (count,), "whole": (count, 2)}
    for name, leaf in found.items():
        assert leaf.dtype == np.float64
        np.testing.assert_array_equal(leaf, whole[name])


def test_every_pack_has_one_shape_and_workers_share_them() -> None:
    """One compilation serves all packs, and no pack is larger than asked for."""
    shapes, threads = set(), set()

    def program(lanes: np.ndarray) -> np.ndarray:
        shapes.add(lanes.shape)
        threads.add(threading.get_ident())
        meeting.wait(timeout=20)
        return lanes

    meeting = threading.Barrier(2)
    in_packs(program, np.arange(10.0), pack=3, workers=2)
    assert len(shapes) == 1
    assert max(shapes)[0] <= 3
    assert len(threads) == 2


def test_a_failure_in_a_pack_is_the_callers() -> None:
    def program(lanes: np.ndarray) -> np.ndarray:
        raise ArithmeticError("no")

    with pytest.raises(ArithmeticError):
        in_packs(program, np.arange(5.0), workers=2)


@pytest.mark.parametrize("lanes", [np.zeros(0), {"a": np.zeros(3), "b": np.zeros(4)}])
def test_no_lanes_or_unequal_lanes_are_refused(lanes: object) -> None:
    with pytest.raises(ValueError, match="number of lanes"):
        in_packs(lambda lanes: lanes, lanes)


def test_a_compiled_function_serves_under_every_transformation() -> None:
    """jax takes compiler options at the outermost jit only: inside a caller's they step back."""

    def cube(x: jax.Array) -> jax.Array:
        return x**3

    quick, x = compiled(cube), jnp.asarray([1.0, 2.0])
    expected = {"value": x**3, "slope": 3 * x**2}
    np.testing.assert_allclose(quick(x), expected["value"])
    np.testing.assert_allclose(jax.jit(quick)(x), expected["value"])
    np.testing.assert_allclose(jax.vmap(quick)(x), expected["value"])
    np.testing.assert_allclose(jax.jit(jax.vmap(jax.grad(quick)))(x), expected["slope"])
    np.testing.assert_allclose(jax.grad(lambda x: quick(x).sum())(x), expected["slope"])


def test_infinities_and_nan_keep_their_meaning() -> None:
    """The options let sums be reassociated, nothing more."""

    @compiled
    def looked_at(x: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
        return jnp.isnan(x), jnp.isinf(x), jnp.where(x < jnp.inf, x, -1.0)

    nan, infinite, cut = looked_at(jnp.asarray([np.nan, np.inf, -np.inf, 2.0]))
    assert nan.tolist() == [True, False, False, False]
    assert infinite.tolist() == [False, True, True, False]
    assert cut.tolist() == [-1.0, -1.0, -np.inf, 2.0]


@pytest.mark.parametrize("in_rows", [True, False])
@pytest.mark.parametrize("count", [1, WIDTH, 2 * WIDTH + 3])
def test_jacobian_of_every_lane(count: int, in_rows: bool) -> None:
    """Derivatives of a tree of results, and more of them, by rows that lanes do not fill and by lanes."""

    def function(point: jax.Array, scale: dict[str, jax.Array]):
        wave = jnp.sin(point[0] * jnp.arange(4.0)) * scale["s"] + point[1]
        return (wave, point[0] * point[1] ** 2), wave

    a, b = points = np.random.default_rng(0).normal(size=(2, count))
    s = np.arange(1.0, count + 1)
    program = compiled(lambda p, s: lane_jacobian(function, p, s, in_rows=in_rows))
    (wave, product), wave_itself = program(jnp.asarray(points.T), {"s": jnp.asarray(s)})
    phase = np.outer(a, np.arange(4.0))
    np.testing.assert_allclose(wave_itself, np.sin(phase) * s[:, None] + b[:, None], rtol=1e-12)
    by_a = np.cos(phase) * np.arange(4.0) * s[:, None]
    np.testing.assert_allclose(wave, np.stack([by_a, np.ones_like(by_a)], axis=2), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(product, np.stack([b**2, 2 * a * b], axis=1), rtol=1e-12)
