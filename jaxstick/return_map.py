"""The return map of a sine-driven oscillator: its state one drive period later, for many lanes at once.

A lane is one oscillator on its own grid of equal steps; lanes are the leading axis of the leaves of one
`Lap`. The loop over the steps ends when the lane with most of them has arrived; their number is no part of
the compiled program, and a lane that has arrived stands still. So one compilation serves all lanes.

The state is a vector: displacement, velocity, the private states of contact, rig and friction law, and the
acceleration that the scheme carries from step to step. The instrument does not act on the motion and has no
part in it. A part that knows the time itself sees that of the first lap.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from jaxstick.oscillator import Oscillator, Start, State
from jaxstick.parts.drive import Excitation, SineDrive
from jaxstick.solver import step
from jaxstick.turns import sine_and_cosine

BLOCK = 8
"""Steps between two looks at the clock: every lane makes a multiple of them, and the phase of the drive is
computed anew for each block, so that it is exact however long the lap."""

UNROLLED = 2

DISPLACEMENT, VELOCITY, ACCELERATION = 0, 1, -1
"""Where these stand in the vector."""

Vector = Float[Array, " size"]


class Lap(eqx.Module):
    """One lane's way through `cycles` periods of the drive.

    period [s]; section, where the lap begins and ends, in periods after time zero; steps, in a period, a
    multiple of `BLOCK`; all floats, or arrays of lanes.
    """

    oscillator: Oscillator
    period: Any
    section: Any
    steps: Any
    cycles: Any


class Moving(NamedTuple):
    """The part of an oscillator's state that its motion depends on; `Vector` holds it in this order."""

    x: Any
    v: Any
    contact: Any
    rig: Any
    law: Any
    acceleration: Any


class Node(NamedTuple):
    """A node of the grid: the motion, the friction force there [N] (not known where a block begins), the
    excitation, sine and cosine of the drive's phase."""

    moving: Moving
    friction: Array
    excitation: Excitation
    sine: Array
    cosine: Array


class Traverse(NamedTuple):
    """The end of a lap; the least and the greatest value of every component on the way; the state where the
    velocity was greatest, and how far from the beginning that was, in periods. All but the end are looked at
    once a block."""

    end: Any
    least: Any
    greatest: Any
    fastest: Any
    fastest_at: Any


Observe = Callable[[Any, Node, Node, Array], Any]
"""From what was seen so far, the nodes before and after a step, and the step [s], to what is seen now."""


def beginning(lap: Lap) -> Vector:
    """The state of an oscillator at rest where the lap begins."""
    return ravel_pytree(_at_rest(lap))[0]


def _at_rest(lap: Lap) -> Moving:
    t = lap.section * lap.period
    state = lap.oscillator.initial(t, Start())
    acceleration = lap.oscillator.acceleration(t, state)
    moving = Moving(state.x, state.v, state.contact, state.rig, state.law, acceleration)
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, float), moving)


def unravelled(lap: Lap, vector: Vector) -> Moving:
    """The state that a vector stands for."""
    shapes = jax.eval_shape(_at_rest, lap)
    like = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), shapes)
    return ravel_pytree(like)[1](vector)


def _excitation(lap: Lap, sine: Array, cosine: Array, t: Array) -> Excitation:
    drive = lap.oscillator.drive
    if not isinstance(drive, SineDrive):
        return drive.at(t)
    omega = 2 * jnp.pi * jnp.asarray(drive.frequency)
    amplitude = jnp.asarray(drive.base_amplitude)
    return Excitation(
        amplitude * sine,
        amplitude * omega * cosine,
        -amplitude * omega**2 * sine,
        jnp.asarray(drive.force_amplitude) * sine,
    )


def drive_phase(lap: Lap) -> Array:
    """The phase of the drive at time zero [rad]; 0 for a drive that is not simply a sine."""
    drive = lap.oscillator.drive
    return jnp.asarray(drive.phase if isinstance(drive, SineDrive) else 0.0)


def block_of_steps(
    lap: Lap, number: Array, vector: Vector, observe: Observe, seen: Any, unrolled: int = UNROLLED
) -> tuple[Vector, Any]:
    """`BLOCK` steps from node BLOCK `number` on: the state after them and what was seen on the way. Where the
    lap is over neither changes."""
    oscillator, h = lap.oscillator, lap.period / lap.steps
    first = jnp.asarray(number, float) * BLOCK
    origin = (lap.section + first / lap.steps) * lap.period
    turns = jnp.mod(first, lap.steps) / lap.steps + lap.section + drive_phase(lap) / (2 * jnp.pi)
    sine, cosine = sine_and_cosine(turns)
    turn_sine, turn_cosine = sine_and_cosine(1 / lap.steps)

    def forward(index: Array, carry: tuple[Node, Any]) -> tuple[Node, Any]:
        node, seen = carry
        for further in range(1, unrolled + 1):
            sine = node.sine * turn_cosine + node.cosine * turn_sine
            cosine = node.cosine * turn_cosine - node.sine * turn_sine
            t = origin + (index * float(unrolled) + further) * h
            after = _excitation(lap, sine, cosine, t)
            x, v, contact, rig, law, acceleration = node.moving
            state, acceleration = step(
                oscillator,
                t,
                h,
                node.excitation,
                after,
                State(x, v, 0.0, contact, rig, law, None),
                acceleration,
            )
            moving = Moving(state.x, state.v, state.contact, state.rig, state.law, acceleration)
            arrived = Node(moving, jnp.asarray(state.friction), after, sine, cosine)
            seen = observe(seen, node, arrived, h)
            node = arrived
        return node, seen

    node = Node(
        unravelled(lap, vector), jnp.zeros_like(h), _excitation(lap, sine, cosine, origin), sine, cosine
    )
    node, now = jax.lax.fori_loop(0, BLOCK // unrolled, forward, (node, seen))
    under_way = first < lap.steps * lap.cycles
    return (
        jnp.where(under_way, ravel_pytree(node.moving)[0], vector),
        jax.tree.map(lambda new, old: jnp.where(under_way, new, old), now, seen),
    )


def nothing(seen: Any, before: Node, after: Node, h: Array) -> Any:
    """Observes nothing."""
    del before, after, h
    return seen


def traverse(lap: Lap, vector: Vector, blocks: Array) -> Traverse:
    """One lap from the state `vector`; `blocks` is how many blocks the longest of all lanes takes."""

    def block(number: Array, way: Traverse) -> Traverse:
        now, _ = block_of_steps(lap, number, way.end, nothing, ())
        faster = now[VELOCITY] > way.fastest[VELOCITY]
        return Traverse(
            now,
            jnp.minimum(way.least, now),
            jnp.maximum(way.greatest, now),
            jnp.where(faster, now, way.fastest),
            jnp.where(faster, (number + 1.0) * BLOCK / lap.steps, way.fastest_at),
        )

    return jax.lax.fori_loop(0, blocks, block, Traverse(vector, vector, vector, vector, jnp.zeros(())))


def returned(lap: Lap, vector: Vector, blocks: Array) -> Vector:
    """The state at the end of the lap, compiled for derivatives: step by step, nothing else looked at."""

    def block(number: Array, vector: Vector) -> Vector:
        return block_of_steps(lap, number, vector, nothing, (), unrolled=1)[0]

    return jax.lax.fori_loop(0, blocks, block, vector)
