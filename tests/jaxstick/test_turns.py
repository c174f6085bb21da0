"""Sine and cosine of turns against long doubles, and their derivatives."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxstick.turns import sine_and_cosine


def test_right_to_the_last_digits() -> None:
    """Over three turns to either side, the folds of the series at every eighth of a turn included."""
    turns = np.concatenate([np.linspace(-3, 3, 20011), np.arange(-24, 25) / 8])
    part = np.longdouble(turns) - np.round(np.longdouble(turns))
    angle = 2 * np.arccos(np.longdouble(-1)) * part
    sine, cosine = (np.asarray(found) for found in sine_and_cosine(jnp.asarray(turns)))
    assert np.abs(sine - np.sin(angle)).max() < 5e-16
    assert np.abs(cosine - np.cos(angle)).max() < 5e-16


def test_derivatives_are_each_other() -> None:
    """d sin = 2 pi cos, d cos = -2 pi sin, forwards, backwards and twice."""
    at = jnp.asarray(0.3)

    def sine(turns: jax.Array) -> jax.Array:
        return sine_and_cosine(turns)[0]

    s, c = np.sin(0.6 * np.pi), np.cos(0.6 * np.pi)
    np.testing.assert_allclose(jax.jvp(sine, (at,), (jnp.asarray(1.0),))[1], 2 * np.pi * c, rtol=1e-14)
    np.testing.assert_allclose(jax.grad(sine)(at), 2 * np.pi * c, rtol=1e-14)
    np.testing.assert_allclose(jax.grad(jax.grad(sine))(at), -4 * np.pi**2 * s, rtol=1e-14)


def test_what_is_not_a_number_stays_so() -> None:
    assert np.isnan(sine_and_cosine(jnp.asarray(np.nan))).all()
