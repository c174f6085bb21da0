"""Extremes, harmonics and work of a lap, summed up while it is run."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.parts.rig import AbstractRig, Rig
from jaxstick.return_map import DISPLACEMENT, Lap, Node, Vector, block_of_steps

HARMONICS = 9

LOOKS = 64
"""Blocks of steps that a recording runs through in one call of the compiled program."""


class Sums(NamedTuple):
    """Greatest and least displacement [m]; sums over the steps of displacement times cosine and sine of the
    first nine multiples of the drive's phase [m]; work lost to friction and to the linear dampers [J]."""

    highest: Float[Array, ""]
    lowest: Float[Array, ""]
    cosines: tuple[Float[Array, ""], ...]
    sines: tuple[Float[Array, ""], ...]
    friction: Float[Array, ""]
    viscous: Float[Array, ""]


class Amounts(NamedTuple):
    """What a lap amounts to, a drive cycle on average: half of peak to peak [m]; the harmonics of the
    displacement as cosine and sine parts [m], x = sum a_k cos(k p) + b_k sin(k p) with p the drive's phase;
    the work that friction and linear dampers dissipate [J]."""

    amplitude: Any
    cosines: Any
    sines: Any
    friction_work: Any
    viscous_work: Any


def no_sums(vector: Vector) -> Sums:
    """Nothing summed yet."""
    zero, many = jnp.zeros(()), (jnp.zeros(()),) * HARMONICS
    return Sums(vector[DISPLACEMENT], vector[DISPLACEMENT], many, many, zero, zero)


def summed_through(lap: Lap, number: Array, vector: Vector, sums: Sums) -> tuple[Vector, Sums]:
    """One block of steps and the sums with it."""
    rig, surface = lap.oscillator.rig, lap.oscillator.rig.surface

    def observe(seen: Sums, before: Node, after: Node, h: Array) -> Sums:
        x0, v0, x, v = before.moving.x, before.moving.v, after.moving.x, after.moving.v
        turns = v0 * v < 0
        peak = x0 + h / 2 * v0**2 / jnp.where(turns, v0 - v, 1.0)
        sliding = v - surface(after.excitation).rate
        cosines, sines = _multiples(after.cosine, after.sine)
        return Sums(
            jnp.maximum(seen.highest, jnp.where(turns & (v0 > 0), peak, x)),
            jnp.minimum(seen.lowest, jnp.where(turns & (v0 < 0), peak, x)),
            tuple(sum_ + x * cosine for sum_, cosine in zip(seen.cosines, cosines, strict=True)),
            tuple(sum_ + x * sine for sum_, sine in zip(seen.sines, sines, strict=True)),
            seen.friction - h * after.friction * sliding,
            seen.viscous + h * _damped(rig, v, after.excitation.y_rate),
        )

    return block_of_steps(lap, number, vector, observe, sums, unrolled=1)


def amounts(lap: Lap, sums: Sums) -> Amounts:
    """What the sums over a whole lap amount to."""
    scale = 2 / (lap.steps * lap.cycles)
    return Amounts(
        (sums.highest - sums.lowest) / 2,
        jnp.stack(sums.cosines) * scale,
        jnp.stack(sums.sines) * scale,
        sums.friction / lap.cycles,
        sums.viscous / lap.cycles,
    )


def lap_amounts(lap: Lap, vector: Vector, blocks: Array) -> tuple[Vector, Amounts]:
    """A whole lap: its end and what it amounts to, differentiable forward."""

    def block(number: Array, carry: tuple[Vector, Sums]) -> tuple[Vector, Sums]:
        return summed_through(lap, number, *carry)

    end, sums = jax.lax.fori_loop(0, blocks, block, (vector, no_sums(vector)))
    return end, amounts(lap, sums)


def recorded(
    lap: Lap, vector: Vector, sums: Sums, first: Array
) -> tuple[Vector, Sums, Float[Array, " looks"]]:
    """`LOOKS` blocks from block `first` on: state and sums after them, and the displacement after each."""

    def block(carry: tuple[Vector, Sums], number: Array) -> tuple[tuple[Vector, Sums], Array]:
        vector, sums = summed_through(lap, number, *carry)
        return (vector, sums), vector[DISPLACEMENT]

    (vector, sums), seen = jax.lax.scan(block, (vector, sums), first + jnp.arange(LOOKS))
    return vector, sums, seen


def rigs_in(module: Any) -> list[Rig]:
    """The linear rigs inside a module, however they are wrapped."""

    def found(node: Any) -> bool:
        return isinstance(node, Rig)

    return [node for node in jax.tree.leaves(module, is_leaf=found) if found(node)]


def _multiples(cosine: Array, sine: Array) -> tuple[list[Array], list[Array]]:
    """Cosine and sine of the first multiples of an angle."""
    cosines, sines = [cosine], [sine]
    for _ in range(HARMONICS - 1):
        c, s = cosines[-1], sines[-1]
        cosines.append(c * cosine - s * sine)
        sines.append(s * cosine + c * sine)
    return cosines, sines


def _damped(rig: AbstractRig, v: Array, base_rate: Array) -> Array:
    """The power that the linear dampers take [W]: those to the ground and those to the base."""
    power = jnp.zeros_like(v)
    for linear in rigs_in(rig):
        to_base = linear.drive_damping
        power += (linear.damping - to_base) * v**2 + to_base * (v - base_rate) ** 2
    return power
