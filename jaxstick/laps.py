"""Laps of many oscillators: sorted by the work they take, in packs, several packs at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace
from typing import Any

import jax
import numpy as np
from numpy.typing import NDArray

from jaxstick.compiled import compiled_for_arrays, cores
from jaxstick.cycle_sums import LOOKS, Amounts, Sums, amounts, no_sums, recorded, rigs_in
from jaxstick.oscillator import Oscillator
from jaxstick.parts.instrument import IdealInstrument
from jaxstick.return_map import BLOCK, Lap, Traverse, beginning, traverse

WIDTH = 32
"""Lanes that go through a program together, filled up where there are fewer. One width for all: the compiler
rounds differently in programs of different widths, and a motion that is not periodic shows it. A step costs
85 ns and 3 ns a lane where loops over small arrays are compiled as code, else 170 ns and 12 ns."""

Real = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Course:
    """Laps to be made, each array of shape (laps,): by which oscillator, from which section [periods after
    time zero], with how many steps a period, for how many periods."""

    lane: Index
    section: Real
    steps: Real
    cycles: Real

    def __len__(self) -> int:
        return len(self.lane)

    def take(self, which: Any) -> Course:
        """Some of them: a mask or indices."""
        return Course(*(getattr(self, field.name)[which] for field in fields(self)))

    def but(self, **changed: Real) -> Course:
        """The same laps with other sections, steps or cycles."""
        return replace(self, **changed)


Digest = Callable[[Course, Real], Any]
"""From some laps and their displacement (laps, blocks), at the end of every block and beyond the end of the
shorter ones, to a tree of arrays with a leading axis of laps."""


class Laps:
    """Oscillators whose laps can be run: `oscillators` has leaves of shape (lanes,), `periods` [s] likewise.

    What the instruments read is of no concern, so they are left out.
    """

    def __init__(self, oscillators: Oscillator, periods: Real, workers: int | None = None):
        self.periods = np.asarray(periods, np.float64)
        self.oscillators = self.bare(oscillators)
        self._workers = workers or cores()

    @classmethod
    def of(cls, oscillators: Sequence[Oscillator]) -> Laps:
        """Oscillators of one build under sine drives, as lanes in this order."""
        stacked = jax.tree.map(
            lambda *leaves: np.stack([np.asarray(leaf, np.float64) for leaf in leaves]), *oscillators
        )
        return cls(stacked, 1 / np.asarray(stacked.drive.frequency, np.float64))

    def bare(self, oscillators: Oscillator) -> Oscillator:
        """Oscillators without instruments, every leaf an array with a leading axis of lanes."""

        def over_lanes(leaf: Any) -> Real:
            values = np.asarray(leaf, np.float64)
            return np.broadcast_to(values, self.periods.shape) if values.ndim == 0 else values

        return jax.tree.map(over_lanes, replace(oscillators, instrument=IdealInstrument()))

    def __len__(self) -> int:
        return len(self.periods)

    def steps(self, resolution: float) -> Real:
        """Steps a period for every lane: `resolution` on the ring of the contact, half as many on the drive's
        cycle, rounded up to whole blocks."""
        ring = 2 * math.pi * np.sqrt(self._inertia() / (self._contact() + self._stiffness()))
        needed = np.maximum(resolution * self.periods / ring, resolution / 2)
        return BLOCK * np.ceil(needed / BLOCK)

    def natural_frequency(self) -> Real:
        """sqrt(K/m)/(2 pi) of every lane [Hz], 0 where the rig has no linear spring."""
        return np.sqrt(self._stiffness() / self._inertia()) / (2 * math.pi)

    def _inertia(self) -> Real:
        return np.asarray(self.oscillators.rig.inertia(), np.float64)

    def _contact(self) -> Real:
        return np.asarray(self.oscillators.contact.k1, np.float64)

    def _stiffness(self) -> Real:
        linear = rigs_in(self.oscillators.rig)
        return np.asarray(linear[0].stiffness, np.float64) if linear else np.zeros(len(self))

    def begin(self, course: Course) -> Real:
        """The states of oscillators at rest at their sections, shape (laps, size)."""
        return self.run(_begin, course)

    def traverse(self, course: Course, vectors: Real) -> Traverse:
        """The laps from these states (laps, size); all leaves numpy arrays with a leading axis of laps."""
        return self.run(_traverse, course, vectors)

    def jacobian(
        self, course: Course, vectors: Real, increments: Real, wanted: Mask, ends: Real | None = None
    ) -> tuple[Real, Real]:
        """The ends of the laps from these states (laps, size), run with the rest where they are not given,
        and their derivatives with respect to the wanted components of the state (laps, size), by differences
        forward of these increments: (laps, size, size), 0 where not wanted."""
        lap, column = np.nonzero(wanted)
        step = increments[lap, column]
        moved = vectors[lap]
        moved[np.arange(len(lap)), column] += step
        also = np.arange(len(vectors) if ends is None else 0)
        found = self.traverse(
            course.take(np.concatenate([also, lap])), np.concatenate([vectors[also], moved])
        ).end
        own_ends = found[also] if ends is None else ends
        derivatives = np.zeros((*vectors.shape, vectors.shape[1]))
        derivatives[lap, :, column] = (found[len(also) :] - own_ends[lap]) / step[:, None]
        return own_ends, derivatives

    def record(self, course: Course, vectors: Real, digest: Digest) -> tuple[Real, Amounts, Any]:
        """The laps from these states: their ends, what they amount to, and what `digest` makes of the
        displacement. All have a leading axis of laps.

        Only the packs that are under way are held in memory.
        """

        def program(laps: Lap, vectors: Real, which: Real, blocks: np.int64) -> tuple[Any, Amounts, Any]:
            sums, seen = _no_sums(vectors), []
            for first in range(0, int(blocks), LOOKS):
                vectors, sums, looks = _recorded(laps, vectors, sums, np.int64(first))
                seen.append(np.asarray(looks))
            displacement = np.concatenate(seen, axis=1)
            return vectors, _amounts(laps, sums), digest(course.take(which), displacement)

        return self.run(program, course, vectors, np.arange(len(course)))

    def run(self, program: Callable[..., Any], course: Course, *arrays: Any) -> Any:
        """`program(lap, *arrays, blocks)` for every lap of the course, in packs: a tree of numpy arrays.
        Trees that the program takes and returns have a leading axis of laps."""
        blocks = course.steps * course.cycles / BLOCK
        order = np.argsort(-blocks, kind="stable")
        packs = [order[first : first + WIDTH] for first in range(0, len(order), WIDTH)]

        def one(pack: Index) -> Any:
            filled = np.concatenate([pack, np.repeat(pack[-1:], WIDTH - len(pack))])
            with jax.enable_x64(True):
                out = program(
                    self._lap(course.take(filled)),
                    *jax.tree.map(lambda array: array[filled], arrays),
                    np.int64(blocks[pack].max()),
                )
            return jax.tree.map(lambda leaf: np.asarray(leaf)[: len(pack)], out)

        if len(packs) == 1:
            found = [one(packs[0])]
        else:
            with ThreadPoolExecutor(self._workers) as pool:
                found = list(pool.map(one, packs))
        back = np.argsort(np.concatenate(packs), kind="stable")
        return jax.tree.map(lambda *leaves: np.concatenate(leaves)[back], *found)

    def _lap(self, course: Course) -> Lap:
        oscillators = jax.tree.map(lambda leaf: leaf[course.lane], self.oscillators)
        return Lap(oscillators, self.periods[course.lane], course.section, course.steps, course.cycles)


@compiled_for_arrays
def _begin(laps: Lap, blocks: Any) -> Any:
    del blocks
    return jax.vmap(beginning)(laps)


@compiled_for_arrays
def _traverse(laps: Lap, vectors: Any, blocks: Any) -> Traverse:
    return jax.vmap(traverse, in_axes=(0, 0, None))(laps, vectors, blocks)


@compiled_for_arrays
def _no_sums(vectors: Any) -> Sums:
    return jax.vmap(no_sums)(vectors)


@compiled_for_arrays
def _recorded(laps: Lap, vectors: Any, sums: Sums, first: Any) -> tuple[Any, Sums, Any]:
    return jax.vmap(recorded, in_axes=(0, 0, 0, None))(laps, vectors, sums, first)


@compiled_for_arrays
def _amounts(laps: Lap, sums: Sums) -> Amounts:
    return jax.vmap(amounts)(laps, sums)
