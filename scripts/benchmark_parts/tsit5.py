"""diffrax's adaptive Tsit5 on the smooth contact, all lanes under one vmap."""

from __future__ import annotations

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from jaxstick.compiled import compiled
from jaxstick.oscillator import Flow, Oscillator
from jaxstick.parts.contact import SmoothContact
from scripts.benchmark_parts.lanes import SAMPLES, Lanes
from scripts.benchmark_parts.ours import oscillator

MOST_STEPS = 1_000_000


def _smooth(lane: Lanes) -> Oscillator:
    loaded = oscillator(lane)
    return Oscillator(loaded.rig, loaded.drive, loaded.friction, SmoothContact(lane.k1))


@compiled
def _solve(lanes: Lanes, interval: Array, tolerance: Array) -> Array:
    def one(lane: Lanes, interval: Array) -> Array:
        rest = jnp.zeros(())
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(_smooth(lane).vector_field),  # pyright: ignore[reportArgumentType]
            diffrax.Tsit5(),
            0.0,
            interval * (SAMPLES - 1),
            1e-5,
            Flow(rest, rest, rest),
            saveat=diffrax.SaveAt(ts=interval * jnp.arange(SAMPLES, dtype=interval.dtype)),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=1e-3 * tolerance),
            max_steps=MOST_STEPS,
            adjoint=diffrax.ForwardMode(),
        )
        assert solution.ys is not None
        return solution.ys.x

    return jax.vmap(one)(lanes, interval)


def simulate(lanes: Lanes, tolerance: float) -> np.ndarray:
    """Displacement at the samples; the tolerance is relative, and a thousandth of it absolute."""
    return np.asarray(_solve(lanes, lanes.interval, jnp.asarray(tolerance)))
