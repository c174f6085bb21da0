"""Derivatives through stick and slip: forward, reverse and central differences agree."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from jaxstick.oscillator import Oscillator, Start
from jaxstick.parameter import replace as with_values
from jaxstick.parts.contact import AbstractContact, LoadedContact, PaperContact, SmoothContact
from jaxstick.simulate import Grid, march
from tests.jaxstick.twin import twin
from tests.reference import rig1987

NAMES = ("A", "B", "C", "D", "k1")
RIG = replace(rig1987.rig(), D=0.5)
POINT = np.array([RIG.A, RIG.B, RIG.C, RIG.D, RIG.k1, 1e-3, 0.05, -2.0])
"""The constants, then displacement, velocity and contact force at the start."""
SAMPLES = 2800
"""In every record, however long it is in seconds, so that all are computed by the same programs."""


@jax.jit
def _outcome(point: Array, oscillator: Oscillator, interval: float) -> Array:
    """Weighted sums of displacement and force over the record and the last displacement, of order one."""
    weights = jnp.sin(0.37 * jnp.arange(SAMPLES, dtype=float))
    changed = with_values(oscillator, {name: point[i] for i, name in enumerate(NAMES)})
    run = march(changed, Start(*point[5:]), Grid(0.0, interval, SAMPLES, 10))
    return jnp.stack([1e3 * jnp.sum(weights * run.x), 0.1 * jnp.sum(weights * run.friction), 1e3 * run.x[-1]])


_forward = jax.jit(jax.jacfwd(_outcome))
_reverse = jax.jit(jax.jacrev(_outcome))


def _central_difference(outcome: Callable[[Array], Array], point: np.ndarray, index: int) -> np.ndarray:
    """The fourth-order central difference, of a ladder of step sizes the one that agrees best with both its
    neighbours: large steps meet events that cross a node of the grid, small ones rounding."""
    ladder = []
    for share in 10.0 ** np.arange(-4.0, -7.1, -0.25):
        shift = np.zeros_like(point)
        shift[index] = share * max(abs(point[index]), 1e-3)
        near, far = (
            np.asarray(outcome(jnp.asarray(point + n * shift)) - outcome(jnp.asarray(point - n * shift)))
            for n in (1, 2)
        )
        ladder.append((8 * near - far) / (12 * shift[index]))
    spread = [np.abs(a - b).max() for a, b in itertools.pairwise(ladder)]
    return ladder[int(np.argmin(np.maximum(spread[:-1], spread[1:]))) + 1]


@pytest.mark.parametrize(
    ("contact", "ratio"),
    [
        (LoadedContact, 0.326),
        (LoadedContact, 0.046),
        (SmoothContact, 0.326),
        (SmoothContact, 0.046),
        (PaperContact, 0.326),
    ],
)
def test_forward_is_reverse_is_central_difference(contact: type[AbstractContact], ratio: float) -> None:
    """For every constant and the initial state, over 1.2 cycles: two stops, and ten at the low ratio.

    The paper's contact at the low ratio is chaotic, where no derivative means anything.
    """
    drive = rig1987.drive(ratio)
    oscillator, interval = twin(RIG, drive, contact), 1.2 / drive.frequency / SAMPLES
    point = jnp.asarray(POINT)
    forward = np.asarray(_forward(point, oscillator, interval))
    reverse = np.asarray(_reverse(point, oscillator, interval))
    scale = np.abs(forward).max(axis=0)
    assert np.all(scale > 0)
    assert np.abs(forward - reverse).max(axis=0) == pytest.approx(0, abs=1e-10 * scale.max())
    for index in range(len(POINT)):
        difference = _central_difference(lambda at: _outcome(at, oscillator, interval), POINT, index)
        gap = np.abs(difference - forward[:, index]).max() / scale[index]
        assert gap < (1e-6 if ratio > 0.1 else 1e-5), f"{index}: {gap:.1e}"


def test_derivatives_under_vmap_are_those_of_each_lane() -> None:
    """Forward and reverse, lanes over frequency: vmap of a derivative is the derivative of each lane."""
    drives = [rig1987.drive(ratio) for ratio in (0.1, 0.326, 0.7, 1.0)]
    frequencies = jnp.array([drive.frequency for drive in drives])
    point = jnp.asarray(POINT)

    def at(frequency: Array) -> Oscillator:
        return with_values(twin(RIG, drives[0]), {"frequency": frequency})

    together_forward = jax.vmap(lambda frequency: _forward(point, at(frequency), 2e-4))(frequencies)
    together_reverse = jax.vmap(lambda frequency: _reverse(point, at(frequency), 2e-4))(frequencies)
    alone = [_reverse(point, twin(RIG, drive), 2e-4) for drive in drives]
    np.testing.assert_allclose(together_forward, alone, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(together_reverse, alone, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0, 1.5])
@pytest.mark.parametrize("decay", [1.0, 30.0, 1000.0])
@pytest.mark.parametrize("stiffness", [10.0, 50.0, 1000.0])
def test_no_dead_gradient(share: float, decay: float, stiffness: float) -> None:
    """Every constant moves the record, across the range of constants in which the paper's rig slips at all.

    Friction from 0.1 to 1.5 times the paper's, B from 1 to 1000 s/m, k1 from 10 K to 1000 K, at two
    frequencies together.
    """
    rig = replace(RIG, A=share * RIG.A, C=share * RIG.C, B=decay, D=1e-3, k1=stiffness * RIG.stiffness)
    point = jnp.asarray([rig.A, rig.B, rig.C, rig.D, rig.k1, 0.0, 0.0, 0.0])
    jacobians = [_forward(point, twin(rig, rig1987.drive(ratio)), 1.2 / SAMPLES) for ratio in (0.19, 0.8)]
    slope = np.abs(np.asarray(jacobians)).max(axis=(0, 1))[:5] * np.asarray(point)[:5]
    assert np.all(np.isfinite(jacobians))
    assert np.all(slope > 5e-9), slope
