"""What changes less and less, against its rate and against closed forms."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxstick.parts.settling import STEADY, settling

FORMS = {
    0.0: lambda age: -np.expm1(-age),
    0.5: lambda age: age / (1 + 0.5 * age),
    1.0: np.log1p,
    2.0: lambda age: 2 * age / (np.sqrt(1 + 2 * age) + 1),
}


@pytest.mark.parametrize("tail", FORMS)
def test_it_settles_in_closed_form(tail: float) -> None:
    times, time = np.array([0.0, 1e-9, 0.01, 0.7, 5.0, 300.0]), 0.4
    np.testing.assert_allclose(
        settling(jnp.asarray(times), time, tail), time * FORMS[tail](times / time), rtol=1e-12
    )
    np.testing.assert_allclose(settling(jnp.asarray(times), STEADY, tail), times, rtol=1e-6)


@given(st.floats(0.0, 2.0), st.floats(1e-3, 1e3), st.floats(0.0, 1e3))
def test_its_rate_falls_as_said(tail: float, time: float, t: float) -> None:
    rate = jax.grad(settling)(t, time, tail)
    slowed = np.exp(-t / time) if tail < 1e-12 else (1 + tail * t / time) ** (-1 / tail)
    np.testing.assert_allclose(rate, slowed, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("tail", [0.0, 1e-7, 1e-3, 1 - 1e-7, 1.0, 1 + 1e-3, 2.0])
@pytest.mark.parametrize("t", [0.0, 1e-6, 0.3, 40.0])
def test_it_changes_smoothly_with_its_tail(t: float, tail: float) -> None:
    time, step = 0.5, 1e-4
    near = [float(settling(t, time, tail + k * step)) for k in (0, 1, 2)]
    forward = (-3 * near[0] + 4 * near[1] - near[2]) / (2 * step)
    for mode in (jax.grad, jax.jacfwd):
        np.testing.assert_allclose(mode(settling, argnums=2)(t, time, tail), forward, rtol=1e-5, atol=1e-9)
