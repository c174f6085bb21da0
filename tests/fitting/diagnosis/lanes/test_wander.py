"""How friction wanders: the widths found, against those that were put in."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from fitting.diagnosis.lanes.wander import OWN, START, Wandering, likeliest
from jaxstick.parts.friction import ExponentialFriction
from jaxstick.parts.motion import Motion

LANES, SAMPLES = 400, 60


def lanes(width: float, noise: float, seed: int) -> tuple[np.ndarray, ...]:
    """Lanes that are linear in what is their own, whose levels have a standard deviation `width` and whose
    slopes have none: what `likeliest` wants to know at own = 0, with prior widths of 0.05."""
    random = np.random.default_rng(seed)
    design = random.standard_normal((LANES, SAMPLES, OWN)) * np.array([1.0, 1.0, 1.0, 300.0, 300.0])
    own = np.zeros((LANES, OWN))
    own[:, :START] = random.standard_normal((LANES, START))
    own[:, START] = width * random.standard_normal(LANES)
    residual = -np.einsum("lro,lo->lr", design, own) + noise * random.standard_normal((LANES, SAMPLES))
    widths = np.full(OWN - START, 0.05)
    curvature = np.einsum("lro,lrp->lop", design, design)
    curvature[:, range(START, OWN), range(START, OWN)] += widths**-2.0
    gradient = np.einsum("lro,lr->lo", design, residual)
    return np.zeros((LANES, OWN)), gradient, curvature, widths, np.full(LANES, noise**2)


@pytest.mark.parametrize("width", [2e-3, 0.02])
@pytest.mark.parametrize("noise", [1.0, 3.0])
def test_the_widths_are_found(width, noise):
    """In units of the noise, as the fit weighs it: `likeliest` is told how much larger the residuals are."""
    found = likeliest(*lanes(width, noise, 1))
    assert found.widths[0] == pytest.approx(width / noise, rel=0.35)
    assert found.widths[1] < 0.1 * width / noise
    information = SAMPLES * 300.0**2
    assert found.price == pytest.approx(LANES * np.log1p(found.widths[0] ** 2 * information), rel=0.2)


def test_friction_that_keeps_still_is_given_no_width():
    found = likeliest(*lanes(0.0, 1.0, 2))
    assert np.all(found.widths < 2e-4)
    assert found.price < 0.3 * LANES


def test_widths_narrow_by_steps():
    """Lanes whose friction has wandered to where it does not belong keep room to come back, however still
    it is in truth; a width is never made wider for that."""
    own, gradient, curvature, widths, share = lanes(0.0, 1.0, 2)
    own[:, START] = 0.02 * np.random.default_rng(7).standard_normal(LANES)
    gradient += np.einsum("lop,lp->lo", curvature, own)
    found = likeliest(own, gradient, curvature, widths, share).widths
    assert 1.5e-3 < found[0] < 3e-3 and found[1] < 2e-4
    assert np.sum((own[:, START] / found[0]) ** 2) < 200 * LANES
    tighter = 1e-4**-2.0 - widths[0] ** -2.0
    gradient[:, START] += tighter * own[:, START]
    curvature[:, START, START] += tighter
    assert likeliest(own, gradient, curvature, np.array([1e-4, widths[1]]), share).widths[0] < 1.2e-4


def test_a_lane_that_fits_far_worse_says_nothing():
    own, gradient, curvature, widths, share = lanes(2e-3, 1.0, 3)
    gradient[:8, START] += 1e7
    share[:8] = 1e3
    assert likeliest(own, gradient, curvature, widths, share).widths[0] == pytest.approx(2e-3, rel=0.35)


def test_a_lane_whose_level_is_far_off_says_nothing():
    """An event that was lost can be made good by friction that is far off, and the lane then costs little."""
    own, gradient, curvature, widths, share = lanes(2e-3, 1.0, 4)
    gradient[:8, START] += 0.1 * SAMPLES * 300.0**2
    found = likeliest(own, gradient, curvature, widths, share).widths
    assert found[0] == pytest.approx(2e-3, rel=0.35)
    assert found[1] < 2e-4


def test_the_factor_on_the_law():
    law = ExponentialFriction(A=1.0, B=5.0, C=3.0, D=2.0)
    wandering = Wandering(law, level=0.1, slope=-0.05, middle=2.0, half=0.5)
    at = Motion(*np.zeros(9), slide_rate=0.2, direction=1.0)
    for time, exponent in ((1.5, 0.15), (2.0, 0.1), (2.5, 0.05)):
        motion = at._replace(t=jnp.asarray(time))
        for part in ("limit", "viscous"):
            plain, changed = (getattr(one, part)(None, motion) for one in (law, wandering))
            assert float(changed) == pytest.approx(float(plain) * np.exp(exponent), rel=1e-5)


def test_lanes_that_tell_next_to_nothing_apart_are_no_failure():
    """Where motion runs away, curvature may be of one direction alone as far as numbers go."""
    own, gradient, curvature, widths, share = lanes(2e-3, 1.0, 5)
    curvature[3] = 1e40
    assert likeliest(own, gradient, curvature, widths, share).widths[0] == pytest.approx(2e-3, rel=0.35)
