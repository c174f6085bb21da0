"""Lags of second order over what was recorded before a start."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.parts.lag import followed, lagged, settled
from jaxstick.parts.track import Trace

LAGS = np.array([0.0, 0.02, 0.05, 0.06, 0.11, 0.2])
VALUES = np.array([1.0, -0.5, 0.3, 0.3, 2.0, 1.5])


def _stepped(time: jax.Array, curvature: jax.Array) -> jax.Array:
    lag = settled(jnp.asarray(VALUES[-1]), jnp.asarray(0.0))
    for value, span in zip(VALUES[-2::-1], np.diff(LAGS)[::-1], strict=True):
        lag = lagged(lag, jnp.asarray(value), jnp.asarray(span), time, curvature)
    return jnp.stack(lag)


def _at_once(time: jax.Array, curvature: jax.Array) -> jax.Array:
    return jnp.stack(followed(Trace(LAGS, VALUES), time, curvature))


BOTH_WAYS = [[jax.jit(of(f)) for f in (_at_once, _stepped)] for of in (lambda f: f, jax.jacfwd, jax.jacrev)]
"""Values, and derivatives by the time in forward and in reverse mode."""


@pytest.mark.parametrize("curvature", [0.0, 0.2, 0.25, 0.45, 400.0])
@pytest.mark.parametrize("time", [0.0, 1e-7, 0.03, 5.0])
def test_what_follows_a_trace_is_where_step_after_step_leads(time: float, curvature: float) -> None:
    """From the oldest point on, settled there; and so are its derivatives by the time."""
    for ways in BOTH_WAYS:
        found, expected = (np.asarray(f(jnp.asarray(time), jnp.asarray(curvature))) for f in ways)
        np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * max(1.0, np.abs(expected).max()))
