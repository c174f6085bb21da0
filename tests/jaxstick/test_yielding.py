"""The derivative of the return mapping in closed form against central differences, in every branch."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.parts.yielding import Window, Yielding, yielding

K1, LIMIT = 1e5, 7.0
BRANCHES = {
    "stick": (1e-6, 2e-5, -6.0),
    "stick, unloading": (-1e-6, 5e-5, -3.0),
    "breaks away in this window": (2e-5, 7.2e-5, -1.8),
    "breaks away behind the node": (2e-5, 6.5e-5, -2.2),
    "breaks away backwards": (-2e-5, -7.2e-5, -1.8),
    "slips": (1e-5, 8e-5, 0.8),
    "slips ever faster": (1e-5, 8e-5, 1.0),
    "slips backwards": (-1e-5, -8e-5, 1.4),
    "comes to rest in this window": (1e-6, 7.05e-5, 0.4),
    "turned round": (-1e-6, 6.9e-5, 0.3),
}
"""Slide [m], trial deflection [m], excess at the last node [N]."""


def _answer(values: jax.Array) -> jax.Array:
    return jnp.stack(yielding(Window(*values)))


ANSWER, FORWARD, REVERSE = jax.jit(_answer), jax.jit(jax.jacfwd(_answer)), jax.jit(jax.jacrev(_answer))


def window(branch: str) -> np.ndarray:
    slide, trial, before = BRANCHES[branch]
    return np.array([slide, trial, LIMIT, before, K1, 3.0, 0.2, 1e-4, 0.08])


@pytest.mark.parametrize("branch", list(BRANCHES))
def test_closed_form_is_central_difference(branch: str) -> None:
    """By every quantity but the slide, of which only the sign counts."""

    point = window(branch)
    forward, reverse = (np.asarray(by(jnp.asarray(point))) for by in (FORWARD, REVERSE))
    np.testing.assert_allclose(reverse, forward, rtol=1e-12, atol=1e-12)
    for index in range(1, len(point)):
        shift = np.zeros_like(point)
        shift[index] = 1e-6 * max(abs(point[index]), 1e-6)
        up, down = (np.asarray(ANSWER(jnp.asarray(point + side * shift))) for side in (1, -1))
        difference = (up - down) / (2 * shift[index])
        scale = np.abs(up).max() / max(abs(point[index]), 1e-6)
        np.testing.assert_allclose(forward[:, index], difference, rtol=1e-5, atol=1e-8 * scale)


def test_branches_are_what_they_are_called() -> None:
    """Between them the windows stick, slip in part and slip throughout."""
    share = {name: float(yielding(Window(*jnp.asarray(window(name)))).slip) for name in BRANCHES}
    assert share["stick"] == share["stick, unloading"] == share["turned round"] == 0.0
    assert share["slips"] == share["slips backwards"] == 1.0
    for name in ("breaks away in this window", "breaks away behind the node", "comes to rest in this window"):
        assert 0.0 < share[name] < 1.0, name


def test_the_force_never_exceeds_the_limit() -> None:
    """At any trial force: what the spring holds is the limit in slip and less in stick."""
    trial = jnp.linspace(-2e-4, 2e-4, 401)
    found: Yielding = jax.vmap(
        lambda z: yielding(Window(z, z, LIMIT, 0.5, K1, 0.0, 0.0, 1e-4, 0.08))  # pyright: ignore
    )(trial)
    assert float(jnp.max(jnp.abs(found.friction))) == pytest.approx(LIMIT, rel=1e-12)
    assert float(jnp.max(K1 * jnp.abs(found.deflection))) == pytest.approx(LIMIT, rel=1e-12)
