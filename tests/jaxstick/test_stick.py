"""What a yielding spring beside the contact has come to while the mass stuck."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.parts.track import Stick, Trace

STIFFNESS, LIMIT, GAP, WIDE = 8e4, 1.1, 4e-6, 2e-5
LAGS = 0.02 * np.arange(96)
REST = 1.5


def swung(lags: np.ndarray) -> np.ndarray:
    """What the contact held, to and fro by more than the narrow gap and by less than the wide one."""
    return 0.2 + 0.45 * np.cos(9.0 * lags - 1.0) + 0.2 * np.cos(2.0 * lags)


SWUNG = swung(LAGS)
NOW = SWUNG[0] + 0.02
"""The force at the start is fitted, and not what a sensor read."""


def stuck(slid: float, held: bool = True) -> Stick:
    forces = np.where((LAGS <= REST) | (slid == 0), SWUNG, 3.0 * np.cos(50.0 * LAGS))
    return Stick(True, NOW, -slid * LIMIT, STIFFNESS, slid, REST, True, Trace(LAGS, forces) if held else None)


@pytest.mark.parametrize("gap", [GAP, WIDE])
@pytest.mark.parametrize("slid", [-1.0, 0.0, 1.0])
def test_it_goes_to_and_fro_with_the_contact_spring(slid: float, gap: float) -> None:
    """From where the mass came to rest on, or as far back as it is known: a play operator in steps a hundred
    times as short. What was held while it slid does not count."""
    stick = stuck(slid)
    fine = np.linspace(LAGS[-1], 0.0, 9501)
    forces = np.where((fine <= REST) | (slid == 0), swung(fine), -slid * LIMIT)
    share = slid
    forces[-1] = NOW
    for change in np.diff(-forces / STIFFNESS / gap):
        share = float(np.clip(share + change, -1.0, 1.0))
    assert abs(share) < 0.95
    assert float(stick.yielded(1 / gap)) == pytest.approx(share, abs=5e-3)


def test_where_nothing_is_known_of_it_it_has_gone_straight_to_where_it_is() -> None:
    """Taken back from its end by how much the contact spring gave way; unknown, it is in the middle."""
    monotonic = Stick(True, 0.9, 1.1, STIFFNESS, -1.0, REST, False, None)
    assert float(monotonic.yielded(1 / GAP)) == pytest.approx(-1 + 0.2 / STIFFNESS / GAP)
    assert float(stuck(1.0, held=False).yielded(1 / GAP)) == -1.0
    assert float(stuck(0.0, held=False).yielded(1 / GAP)) == 0.0
    for slid in (-1.0, 0.0, 1.0):
        silent = stuck(slid)._replace(known=False).yielded(1 / WIDE)
        assert float(silent) == float(stuck(slid, held=False).yielded(1 / WIDE))


def test_a_mass_that_slides_has_slid_it_along() -> None:
    for slid in (-1.0, 0.0, 1.0):
        assert float(stuck(slid)._replace(sticks=False).yielded(1 / GAP)) == slid


def test_its_derivatives_are_those_of_differences() -> None:
    """By what yields, the force at the start, and the contact's stiffness; forwards and backwards."""

    def share(numbers: jax.Array) -> jax.Array:
        per_metre, friction, stiffness = numbers
        return stuck(1.0)._replace(friction=friction, stiffness=stiffness).yielded(per_metre)

    at = jnp.asarray([1 / GAP, NOW, STIFFNESS])
    forwards, backwards = jax.jacfwd(share)(at), jax.jacrev(share)(at)
    steps = 1e-6 * np.diag(np.asarray(at))
    differences = [float(share(at + step) - share(at - step)) / (2 * step.sum()) for step in steps]
    assert np.all(np.asarray(forwards) != 0)
    np.testing.assert_allclose(forwards, differences, rtol=1e-5)
    np.testing.assert_allclose(backwards, differences, rtol=1e-5)
