"""Public entry points compute in float64 whatever the session's setting, and leave the setting alone."""

from __future__ import annotations

import threading

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.precision import float64

pytestmark = pytest.mark.usefixtures("user_session")

X = 1.375  # the same number in float32 and float64
POINTS = np.array([1.375, 0.5])


@float64
def decay(x, count=3):
    """A diffrax solve: inside are loops, counters of 64 bits, checks of values and gradients of its own."""
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(lambda t, y, rate: -rate * y),
        diffrax.Tsit5(),
        t0=0.0,
        t1=2.0,
        dt0=0.1,
        y0=jnp.ones(count) * x,
        args=x,
        saveat=diffrax.SaveAt(ts=jnp.linspace(0.5, 2.0, 4)),
        stepsize_controller=diffrax.PIDController(rtol=1e-10, atol=1e-12),
    )
    return jnp.sum(jnp.asarray(solution.ys))


def decay_exact(x):
    return 3.0 * x * np.exp(-x * np.linspace(0.5, 2.0, 4)).sum()


def decay_slope(x):
    times = np.linspace(0.5, 2.0, 4)
    return 3.0 * ((1.0 - x * times) * np.exp(-x * times)).sum()


@float64
def swing(x):
    """A scan, and operations whose float32 rules do not fit float64 values: argmax, scatter, prefix sums."""

    def step(carry, t):
        z = jnp.clip(carry + 0.01 * x * jnp.cos(t), -0.4, 0.4)
        return z, z

    _, zs = jax.lax.scan(step, 0.1 * x, 0.01 * jnp.arange(100))
    changed = zs.at[3].set(x**2)
    return jnp.sum(changed) + jnp.cumsum(zs)[50] + zs[jnp.argmax(jnp.abs(zs))]


def in_float64(compute):
    """What the same computation gives where the whole session is float64, compiled."""
    with jax.enable_x64(True):
        return np.asarray(jax.jit(compute)())


def test_an_eager_call_is_float64_and_the_setting_stays():
    value = decay(X)
    assert value.dtype == np.float64
    assert value == pytest.approx(decay_exact(X), rel=1e-9)
    assert jnp.ones(1).dtype == np.float32
    assert jax.config.read("jax_enable_x64") is False


def test_the_setting_stays_after_an_error():
    @float64
    def fails(x):
        raise ValueError(f"{x.dtype}")

    with pytest.raises(ValueError, match="float64"):
        fails(np.float32(1.0))
    assert jax.config.read("jax_enable_x64") is False


def test_arrays_are_widened_and_everything_else_is_left_alone():
    @float64
    def dtypes(tree):
        return {name: getattr(leaf, "dtype", type(leaf)) for name, leaf in tree.items()}

    given = {
        "jax": jnp.ones(2),
        "numpy": np.ones(2, np.float32),
        "complex": np.ones(2, np.complex64),
        "counts": np.arange(2, dtype=np.int32),
        "number": 1.5,
        "word": "slip",
    }
    assert dtypes(given) == {
        "jax": np.float64,
        "numpy": np.float64,
        "complex": np.complex128,
        "counts": np.int32,
        "number": float,
        "word": str,
    }


def test_jit():
    value = jax.jit(decay)(X)
    assert value.dtype == np.float64
    assert float(value) == pytest.approx(decay_exact(X), rel=1e-9)


def test_jit_without_an_argument():
    value = jax.jit(lambda: decay(X))()
    assert value.dtype == np.float64
    assert float(value) == pytest.approx(decay_exact(X), rel=1e-9)


def test_jit_around_a_captured_value():
    @float64
    def apply(function):
        return function(jnp.asarray(2.0))

    value = jax.jit(jax.grad(lambda a: apply(lambda x: x * a**3)))(X)
    assert float(value) == pytest.approx(6.0 * X**2, rel=1e-6)


@pytest.mark.parametrize("compiled", [False, True])
def test_grad_is_computed_in_float64_and_rounded_once(compiled):
    gradient = jax.jit(jax.grad(decay)) if compiled else jax.grad(decay)
    assert float(gradient(X)) == np.float32(decay_slope(X))


def test_grad_under_the_context_keeps_every_digit():
    with float64():
        assert float(jax.grad(decay)(X)) == pytest.approx(decay_slope(X), rel=1e-9)
    assert jax.config.read("jax_enable_x64") is False


def test_vmap():
    values = jax.vmap(decay)(POINTS)
    assert values.dtype == np.float64
    assert np.asarray(values) == pytest.approx([decay_exact(x) for x in POINTS], rel=1e-9)


@pytest.mark.parametrize(
    "transformed",
    [jax.jacfwd, lambda f: jax.jit(jax.jacfwd(f)), lambda f: jax.jacfwd(jax.jacfwd(f))],
    ids=["jacfwd", "jit of jacfwd", "twice"],
)
def test_jacfwd_keeps_float64(transformed):
    value = transformed(swing)(X)
    assert value.dtype == np.float64
    assert np.asarray(value) == pytest.approx(in_float64(lambda: transformed(swing)(X)), rel=1e-12)


@pytest.mark.parametrize(
    "transformed",
    [
        lambda f: jax.jit(jax.vmap(jax.grad(f))),
        lambda f: jax.vmap(jax.jit(jax.grad(f))),
        lambda f: jax.vmap(jax.grad(jax.checkpoint(f))),
        lambda f: jax.vmap(lambda x: jax.jvp(jax.grad(f), (x,), (jnp.ones_like(x),))[1]),
        lambda f: jax.vmap(jax.grad(jax.grad(f))),
        lambda f: jax.grad(lambda xs: jnp.dot(jax.vmap(f)(xs).astype(xs.dtype), xs)),
        lambda f: lambda xs: jax.vmap(jax.grad(lambda a, b: f(a * b), argnums=1), (0, None))(xs, xs[0]),
    ],
    ids=[
        "jit vmap grad",
        "vmap jit grad",
        "remat",
        "forward over reverse",
        "twice",
        "grad of vmap",
        "one lane fixed",
    ],
)
def test_reverse_mode_in_every_arrangement(transformed):
    value = np.asarray(transformed(swing)(jnp.asarray(POINTS)))
    assert value == pytest.approx(in_float64(lambda: transformed(swing)(jnp.asarray(POINTS))), rel=3e-7)


def test_the_cotangent_of_a_shared_argument_sums_over_the_lanes():
    def total(x):
        return jnp.sum(jax.vmap(lambda scale: swing(x * scale))(jnp.asarray(POINTS)).astype(jnp.float32))

    assert float(jax.jit(jax.grad(total))(X)) == pytest.approx(
        float(in_float64(lambda: sum(s * jax.grad(swing)(X * s) for s in POINTS))), rel=3e-7
    )


def test_the_transpose_of_a_batched_linear_map():
    @float64
    def product(a, b):
        return jnp.sin(a) * b**2

    push = jax.linearize(product, X, 2.0)[1]
    scales = jnp.asarray(POINTS, np.float32)
    to_first, to_second = jax.linear_transpose(
        lambda da, db: jax.vmap(lambda scale: push(da, scale * db))(scales).astype(np.float32),
        jnp.float32(0.0),
        jnp.float32(0.0),
    )(jnp.asarray([1.0, 10.0]))
    assert float(to_first) == pytest.approx(11.0 * 4.0 * np.cos(X), rel=1e-6)
    assert float(to_second) == pytest.approx((POINTS @ [1.0, 10.0]) * 4.0 * np.sin(X), rel=1e-6)


def test_inside_the_callers_scan():
    def step(carry, _):
        return carry + swing(carry).astype(carry.dtype) / 100, None

    def thrice(x):
        return jax.lax.scan(step, x, None, length=3)[0]

    value, slope = jax.value_and_grad(thrice)(jnp.float32(X))
    assert float(value) == pytest.approx(float(in_float64(lambda: thrice(X))), rel=1e-6)
    assert float(slope) == pytest.approx(float(in_float64(lambda: jax.grad(thrice)(X))), rel=1e-6)


def test_results_of_every_kind_come_back():
    class Answer(eqx.Module):
        value: jax.Array
        unused: jax.Array
        counts: jax.Array
        reason: str = eqx.field(static=True)

    @float64
    def answer(x, reason):
        value = x * jnp.ones(2)
        return Answer(value, unused=jnp.cumsum(value), counts=jnp.arange(3), reason=reason), None, "word"

    result, nothing, word = eqx.filter_jit(answer)(X, "converged")
    assert (nothing, word, result.reason) == (None, "word", "converged")
    assert result.value.dtype == np.float64
    assert np.array_equal(result.counts, [0, 1, 2])
    tangent = jax.jvp(lambda x: answer(x, "")[0], (X,), (1.0,))[1]
    assert np.array_equal(tangent.value, [1.0, 1.0])
    assert float(jax.jit(jax.grad(lambda x: answer(x, "")[0].value[1]))(X)) == 1.0


def test_a_check_of_values_still_speaks():
    @float64
    def root(x):
        return jnp.sqrt(eqx.error_if(x, x < 0, "negative"))

    assert float(eqx.filter_jit(root)(4.0)) == 2.0
    assert float(jax.grad(root)(4.0)) == 0.25
    with pytest.raises(RuntimeError, match="negative"):
        eqx.filter_jit(root)(jnp.asarray(-1.0))


def test_nested_entry_points():
    @float64
    def outer(x):
        return swing(x) + swing(2 * x)

    gradient = jax.jit(jax.grad(outer))
    assert outer(X).dtype == np.float64
    assert float(gradient(X)) == np.float32(in_float64(lambda: gradient(X)))


def test_the_context_holds_for_its_own_thread_alone():
    seen = []
    with float64():
        assert jnp.ones(1).dtype == np.float64
        thread = threading.Thread(target=lambda: seen.append(jnp.ones(1).dtype))
        thread.start()
        thread.join()
    assert seen == [np.float32]


def test_threads_do_not_disturb_each_other():
    seen = {}
    inside, leave = threading.Event(), threading.Event()

    @float64
    def waits():
        inside.set()
        assert leave.wait(10)
        return jnp.ones(1).dtype

    thread = threading.Thread(target=lambda: seen.update(entry=waits()))
    thread.start()
    assert inside.wait(10)
    seen["caller"] = jnp.ones(1).dtype
    leave.set()
    thread.join()
    assert seen == {"entry": np.float64, "caller": np.float32}
