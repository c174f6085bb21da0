"""Simulation on a grid of samples: from an oscillator and a start to a trajectory."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from jaxstick.compiled import compiled
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parts.motion import Scalar
from jaxstick.precision import float64
from jaxstick.solver import Staggered, leap

Substep = Callable[[Any, Array], Any]
"""One integration step: what is carried and the number of the step in, what is carried on."""
See = Callable[[Any, Array], Any]
"""What is seen after a step: what is carried and the number of the step in."""


class Grid(eqx.Module):
    """Samples at start + i interval, i = 0 ... samples - 1 [s], with `substeps` steps between two."""

    start: Float[Array, ""] | float
    interval: Float[Array, ""] | float
    samples: int = eqx.field(static=True)
    substeps: int = eqx.field(static=True, default=1)

    def walk(self, substep: Substep, see: See, carry: Any, first: Any, unroll: int) -> Any:
        """What is seen at every sample; `first`, at the first."""

        def between(carry: Any, count: Array) -> tuple[Any, None]:
            return substep(carry, count), None

        def sample(carry: Any, index: Array) -> tuple[Any, Any]:
            # The last step stands alone: what only a sample shows is then computed once a sample.
            begin, last = index * self.substeps, (index + 1) * self.substeps
            counts = begin + jnp.arange(1, self.substeps)
            carry, _ = jax.lax.scan(between, carry, counts, unroll=max(1, min(unroll, self.substeps - 1)))
            carry = substep(carry, last)
            return carry, see(carry, last)

        later = jax.lax.scan(sample, carry, jnp.arange(self.samples - 1))[1]
        return jax.tree.map(lambda one, more: jnp.concatenate([one[None], more]), first, later)


class OpenGrid(eqx.Module):
    """A grid with room for `samples`, of which the first `reach` are computed, the others 0. That number and
    the number of steps between two samples are arguments of the compiled program, so that one program serves
    any record and any step; for derivatives in forward mode alone."""

    start: Float[Array, ""] | float
    interval: Float[Array, ""] | float
    substeps: Int[Array, ""]
    reach: Int[Array, ""]
    samples: int = eqx.field(static=True)

    def walk(self, substep: Substep, see: See, carry: Any, first: Any, unroll: int) -> Any:
        """As that of `Grid`, in a single loop over all steps, which is traced and compiled much faster than
        one within another; every step writes what is seen where the last before the sample has the last word.
        """
        del unroll

        def put(whole: Any, new: Any, index: Array | int) -> Any:
            return jax.tree.map(
                lambda rows, row: jax.lax.dynamic_update_index_in_dim(rows, row, index, 0), whole, new
            )

        def onward(count: Array, state: tuple[Any, Any]) -> tuple[Any, Any]:
            carry = substep(state[0], count)
            return carry, put(state[1], see(carry, count), (count - 1) // self.substeps + 1)

        blank = jax.tree.map(lambda row: jnp.zeros((self.samples, *row.shape), row.dtype), first)
        last = (self.reach - 1) * self.substeps
        return jax.lax.fori_loop(1, last + 1, onward, (carry, put(blank, first, 0)))[1]


class Trajectory(NamedTuple):
    """A simulated motion, one entry a sample.

    time [s]; x, v displacement and velocity of the mass [m, m/s]; force, the friction force on it [N];
    displacement, friction: what the instrument reads of them [m, N].
    """

    time: Array
    x: Array
    v: Array
    force: Array
    displacement: Array
    friction: Array


def march(oscillator: Oscillator, start: Start, grid: Grid | OpenGrid, unroll: int = 1) -> Trajectory:
    """The trajectory of the return-mapping scheme on a grid; pure, for use under jit, vmap and derivatives.

    Times are counted from integers, so the phase of the drive is exact however long the record. `unroll`
    trades compile time for speed with few lanes, where no derivative is taken.
    """
    interval = jnp.asarray(grid.interval)
    h = interval / jnp.asarray(grid.substeps, interval.dtype)
    origin = jnp.asarray(grid.start)
    state = oscillator.initial(origin, start)
    state = jax.tree.map(jnp.asarray, state)
    acceleration = oscillator.acceleration(origin, state)
    excitation = oscillator.drive.at(origin)

    def time(count: Array) -> Array:
        return origin + h * count.astype(h.dtype)

    def substep(carry: Any, count: Array) -> Any:
        staggered, before, _ = carry
        t = time(count)
        after = oscillator.drive.at(t)
        staggered, acceleration = leap(oscillator, t, h, before, after, staggered)
        return staggered, after, acceleration

    def see(carry: Any, count: Array) -> Any:
        staggered, excitation, acceleration = carry
        return _see(oscillator, time(count), staggered.state, acceleration, excitation)

    first = jax.tree.map(jnp.asarray, _see(oscillator, origin, state, acceleration, excitation))
    begin = Staggered.of(state, acceleration, h), excitation, acceleration
    seen = grid.walk(substep, see, begin, first, unroll)
    times = origin + interval * jnp.arange(grid.samples, dtype=h.dtype)
    return Trajectory(times, *seen)


def _see(
    oscillator: Oscillator, t: Scalar, state: Any, acceleration: Any, excitation: Any
) -> tuple[Any, ...]:
    motion = oscillator.motion(t, excitation, state.x, state.v, acceleration)
    reading = oscillator.instrument.read(state.instrument, motion, state.friction)
    return state.x, state.v, state.friction, reading.displacement, reading.friction


def shortest_period(oscillator: Oscillator) -> float:
    """The period [s] of the fastest free vibration, that of the mass on contact spring and rig; of all lanes
    the shortest."""
    rig, contact = oscillator.rig, oscillator.contact
    stiffness = np.asarray(contact.k1) + np.asarray(getattr(rig, "stiffness", 0.0))
    return float(np.min(2 * math.pi * np.sqrt(np.asarray(rig.inertia()) / stiffness)))


def substeps(interval: float, period: float, resolution: float) -> int:
    """Integration steps a sample so that `resolution` steps fall on the period of the fastest vibration."""
    return max(1, math.ceil(interval * resolution / period))


@compiled
def _march_compiled(oscillator: Oscillator, start: Start, grid: Grid) -> Trajectory:
    return march(oscillator, start, grid)


@float64
def simulate(
    oscillator: Oscillator,
    *,
    samples: int,
    interval: float,
    start: Start | None = None,
    start_time: float = 0.0,
    steps_per_sample: int | None = None,
    resolution: float = 200.0,
) -> Trajectory:
    """Simulates an oscillator from `start`: `samples` samples, `interval` seconds apart, in float64.

    Without `steps_per_sample` the step is chosen so that `resolution` steps fall on a period of the contact's
    ring (error about 5e-6 of the stroke at 200, falling with its square); it must be given where the
    oscillator's stiffness or mass is traced, that is inside a user's own `jax.jit`, `jax.vmap` or `jax.grad`.

    Raises ValueError where samples or interval are not positive.
    """
    if samples < 1 or not interval > 0:
        raise ValueError(f"samples and interval must be positive, got {samples} and {interval}")
    if steps_per_sample is None:
        steps_per_sample = substeps(interval, shortest_period(oscillator), resolution)
    grid = Grid(start_time, interval, samples, steps_per_sample)
    return _march_compiled(oscillator, Start() if start is None else start, grid)
