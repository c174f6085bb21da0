"""How a periodic state and what it amounts to change with the oscillator, by the implicit function theorem.

A lap P(s, p) from state s of an oscillator with parameters p closes where s = P(s, p), so
ds/dp = (I - dP/ds)^-1 dP/dp. Both derivatives are those of the simulation itself, taken forward.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import NDArray

from jaxstick.compiled import compiled
from jaxstick.cycle_sums import Amounts, lap_amounts
from jaxstick.laps import Laps, Real
from jaxstick.oscillator import Oscillator
from jaxstick.return_map import Lap, returned
from jaxstick.steady import PeriodicStates, ordered_multipliers

Vectors = Float[Array, "lanes size"]


def monodromy(laps: Lap, vectors: Vectors, blocks: Array) -> Float[Array, "lanes size size"]:
    """The Jacobians of the laps from these states; their eigenvalues are the Floquet multipliers."""

    def ends(vectors: Vectors) -> Vectors:
        return jax.vmap(returned, in_axes=(0, 0, None))(laps, vectors, blocks)

    def along(direction: Array) -> Array:
        return jax.jvp(ends, (vectors,), (jnp.broadcast_to(direction, vectors.shape),))[1]

    columns = jax.vmap(along)(jnp.eye(vectors.shape[1]))
    return jnp.transpose(columns, (1, 2, 0))


@jax.custom_jvp
def settled(laps: Lap, vectors: Vectors, blocks: Array) -> Vectors:
    """The periodic states of these laps, which `vectors` are already; they move with the oscillators."""
    del laps, blocks
    return vectors


@settled.defjvp
def _settled_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]) -> tuple[Vectors, Vectors]:
    laps, vectors, blocks = primals

    def ends(laps: Lap) -> Vectors:
        return jax.vmap(returned, in_axes=(0, 0, None))(laps, vectors, blocks)

    forced = jax.jvp(ends, (laps,), (tangents[0],))[1]
    system = jnp.eye(vectors.shape[1])[None] - monodromy(laps, vectors, blocks)
    return vectors, jnp.linalg.solve(system, forced[..., None])[..., 0]


class Sensitivity(NamedTuple):
    """Derivatives along directions in the space of parameters, shapes (lanes, directions, ...): of the state
    at the section and of the amounts; and the Jacobian of the lap (lanes, size, size)."""

    state: Any
    amounts: Amounts
    monodromy: Any


@dataclass(frozen=True, eq=False)
class Direction:
    """A direction in which the lanes' oscillators change: the rates of their parameters (leaves of shape
    (lanes,)) and of the drive's period [s]."""

    oscillators: Oscillator
    periods: Real


def sensitivities(laps: Laps, states: PeriodicStates, directions: list[Direction]) -> Sensitivity:
    """Derivatives of periodic states and amounts along these directions; they mean nothing in lanes whose
    motion is not periodic."""
    bare = [laps.bare(direction.oscillators) for direction in directions]
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves, axis=1), *bare)
    periods = np.stack([np.broadcast_to(d.periods, (len(laps),)) for d in directions], axis=1)
    lanes = states.course.lane
    rates = jax.tree.map(lambda leaf: leaf[lanes], (stacked, periods))
    return laps.run(_sensitivities, states.course, states.state, rates)


def multipliers(laps: Laps, states: PeriodicStates) -> NDArray[np.complex128]:
    """The Floquet multipliers of every lane, largest first, from the derivative of the simulation; nan where
    the motion is not periodic. Shape (lanes, size)."""
    return ordered_multipliers(laps.run(_monodromy, states.course, states.state), states.period)


@compiled
def _monodromy(laps: Lap, vectors: Any, blocks: Any) -> Any:
    return monodromy(laps, vectors, blocks)


@compiled
def _sensitivities(laps: Lap, vectors: Any, rates: Any, blocks: Any) -> Sensitivity:
    def found(oscillators: Oscillator, periods: Any) -> tuple[Any, Amounts]:
        moved = Lap(oscillators, periods, laps.section, laps.steps, laps.cycles)
        state = settled(moved, vectors, blocks)
        return state, jax.vmap(lap_amounts, in_axes=(0, 0, None))(moved, state, blocks)[1]

    def along(rate: tuple[Oscillator, Any]) -> tuple[Any, Amounts]:
        return jax.jvp(found, (laps.oscillator, laps.period), rate)[1]

    state, amounts = jax.vmap(along, in_axes=1, out_axes=1)(rates)
    return Sensitivity(state, amounts, monodromy(laps, vectors, blocks))
