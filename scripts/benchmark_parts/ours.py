"""jaxstick: the return-mapping march over lanes, and its Jacobian."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from jaxstick.compiled import LANES_A_PACK, compiled, in_packs, lane_jacobian
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parts.contact import LoadedContact
from jaxstick.parts.drive import SineDrive
from jaxstick.parts.friction import ExponentialFriction
from jaxstick.parts.rig import Rig
from jaxstick.simulate import Grid, march
from scripts.benchmark_parts.lanes import SAMPLES, Lanes

UNROLL = 2


def oscillator(lane: Lanes) -> Oscillator:
    """The oscillator of one lane, or of many with a leading axis."""
    return Oscillator(
        Rig(lane.mass, lane.stiffness, lane.drive_stiffness, lane.damping),
        SineDrive(lane.frequency, lane.amplitude),
        ExponentialFriction(lane.A, lane.B, lane.C, lane.D),
        LoadedContact(lane.k1),
    )


def _displacement(lane: Lanes, interval: Array, steps: int, unroll: int = UNROLL) -> Array:
    return march(oscillator(lane), Start(), Grid(0.0, interval, SAMPLES, steps), unroll).x


@compiled
def _simulated(lanes: tuple[Lanes, Array], steps: int) -> Array:
    return jax.vmap(lambda lane, interval: _displacement(lane, interval, steps))(*lanes)


@compiled
def _ranged(lanes: tuple[Lanes, Array], steps: int) -> Array:
    """Amplitude alone: nothing else of a motion is kept."""
    x = jax.vmap(lambda lane, interval: _displacement(lane, interval, steps))(*lanes)
    return (jnp.max(x, axis=1) - jnp.min(x, axis=1)) / 2


@compiled
def _linearised(lanes: tuple[Lanes, Array], steps: int) -> Array:
    def one(point: Array, lane: Lanes, interval: Array) -> tuple[Array, None]:
        A, B, C, D, k1 = point
        return _displacement(lane._replace(A=A, B=B, C=C, D=D, k1=k1), interval, steps), None

    lane, interval = lanes
    points = jnp.stack([lane.A, lane.B, lane.C, lane.D, lane.k1], axis=1)
    return lane_jacobian(one, points, lane, interval)[0]


def _run(program: Any, lanes: Lanes, steps: int, workers: int | None, pack: int = LANES_A_PACK) -> np.ndarray:
    return in_packs(program, (lanes, lanes.interval), steps, workers=workers, pack=pack)


def simulate(lanes: Lanes, steps: int, workers: int | None = None) -> np.ndarray:
    """Displacement at the samples, shape (lanes, samples); all cores unless `workers` says otherwise."""
    return _run(_simulated, lanes, steps, workers)


def amplitude(lanes: Lanes, steps: int, workers: int | None = None, pack: int = LANES_A_PACK) -> np.ndarray:
    """Half the range of the displacement of every lane, and nothing else kept."""
    return _run(_ranged, lanes, steps, workers, pack)


def jacobian(lanes: Lanes, steps: int, workers: int | None = None) -> np.ndarray:
    """Derivatives of the displacement with respect to A, B, C, D, k1: shape (lanes, samples, 5)."""
    return _run(_linearised, lanes, steps, workers)
