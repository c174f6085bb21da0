"""Lanes: many short segments of records, simulated side by side, each with its own free start."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from fitting.unknowns import Chart, Unknowns
from jaxstick.compiled import QUICKLY, lane_jacobian
from jaxstick.hypothesis import Hypothesis
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parameter import find, replace
from jaxstick.parts.before import Before
from jaxstick.parts.drive import RecordedDrive
from jaxstick.simulate import OpenGrid, Trajectory, march

ROOMS = (32, 256, 2048)
"""Programs have room for so many samples a lane, or four times as many as often as it takes, and compute as
many as there are: few programs serve segments and records of any length."""
SAMPLES, FEWEST = 4096, 8
"""So many samples go through a program together, which stay near the core, but no fewer lanes than this."""

Lane = Float[Array | np.ndarray, " lanes"]
Samples = Float[Array | np.ndarray, "lanes samples"]
Starts = Float[Array | np.ndarray, "lanes 3"]


class Lanes(eqx.Module):
    """Segments of records with a leading axis of lanes; all have the same number of samples.

    `rig_shift` holds what each lane's rig parameters differ by from the hypothesis; weights are reciprocal
    standard deviations of the channels, 0 where a sample does not count; `start` and `start_deviation` are
    the prior of displacement, velocity and contact force at the first sample; `before` is what the record
    says of the time before that.
    """

    rig_shift: Mapping[str, Lane]
    drive: RecordedDrive
    start_time: Lane
    interval: Lane
    displacement: Samples
    friction: Samples
    displacement_weight: Samples
    friction_weight: Samples
    start: Starts
    start_deviation: Starts
    before: Before
    substeps: int = eqx.field(static=True)

    def __len__(self) -> int:
        return self.displacement.shape[0]

    def weights(self) -> np.ndarray:
        """The weights of displacement and friction, (lanes, samples, 2)."""
        return np.stack([np.asarray(self.displacement_weight), np.asarray(self.friction_weight)], axis=2)

    def counted(self) -> np.ndarray:
        """How many residuals of each lane count."""
        return np.sum(self.weights() > 0, axis=(1, 2))

    def base_motion(self) -> tuple[np.ndarray, np.ndarray]:
        """Displacement and velocity of the base at the samples (lanes, samples) [m, m/s]."""
        samples = self.displacement.shape[1]
        finer = np.shape(self.drive.base)[1] // (samples - 1)
        begins = np.asarray(self.drive.continued(samples * finer).base)[:, ::finer]
        return begins[:, :, 3], begins[:, :, 2]

    def take(self, index: np.ndarray) -> Lanes:
        """The lanes at these indices, in this order."""
        return jax.tree.map(lambda leaf: np.asarray(leaf)[index], self)

    def filled(self, samples: int) -> Lanes:
        """The lanes as a program with room for so many samples takes them, at the pace that they have now:
        samples that are new do not count, and the drive has as many pieces, or a power of two times as many.
        """
        have = self.displacement.shape[1]
        pieces = np.asarray(self.drive.base).shape[1]
        finer = 2 ** math.ceil(math.log2(max(1.0, pieces / (have - 1))))
        sampled = ("displacement", "friction", "displacement_weight", "friction_weight")
        arrays = {
            name: np.pad(np.asarray(getattr(self, name)), [(0, 0), (0, samples - have)]) for name in sampled
        }
        return dataclasses.replace(self, drive=self.drive.continued(samples * finer), substeps=1, **arrays)

    def pace(self) -> Pace:
        """The pace of the lanes as they are laid out."""
        return Pace(self.substeps, self.displacement.shape[1])


def lane_oscillator(hypothesis: Hypothesis, lane: Lanes) -> Oscillator:
    """The oscillator of one lane: the hypothesis with the lane's own rig and drive."""
    shifted = {
        f"rig.{name}": find(hypothesis.nominal, f"rig.{name}").of(hypothesis.nominal) + shift
        for name, shift in lane.rig_shift.items()
    }
    nominal = replace(hypothesis.nominal, shifted)
    nominal = eqx.tree_at(lambda oscillator: oscillator.drive, nominal, lane.drive)
    return eqx.tree_at(lambda h: h.nominal, hypothesis, nominal).oscillator()


class Pace(NamedTuple):
    """What a program is told at run time: integration steps a sample, and how many samples lanes reach."""

    substeps: Array | int
    reach: Array | int


def lane_motion(oscillator: Oscillator, lane: Lanes, start: Array, pace: Pace) -> Trajectory:
    """The motion of a lane's oscillator along it from a start."""
    origin, interval = jnp.asarray(lane.start_time), jnp.asarray(lane.interval)
    samples = lane.displacement.shape[-1]
    grid = OpenGrid(origin, interval, jnp.asarray(pace.substeps), jnp.asarray(pace.reach), samples)
    return march(oscillator, Start(start[0], start[1], start[2], lane.before), grid)


def lane_residual(lane: Lanes, motion: Trajectory, start: Array) -> Array:
    """Residuals of one lane in standard deviations: displacement, friction, prior of the start."""
    return jnp.concatenate(
        [
            lane.displacement_weight * (motion.displacement - lane.displacement),
            lane.friction_weight * (motion.friction - lane.friction),
            (start - lane.start) / lane.start_deviation,
        ]
    )


def lane_end(lane: Lanes, motion: Trajectory) -> Array:
    """Displacement, velocity and friction force at the sample after the last that counts."""
    count = jnp.sum(jnp.asarray(lane.displacement_weight) > 0)
    return jnp.stack([motion.x[count], motion.v[count], motion.force[count]])


class Linearisation(NamedTuple):
    """Per lane, with r the residuals and J their derivative with respect to unknowns and start:
    r.r, J'r and J'J."""

    cost: np.ndarray
    gradient: np.ndarray
    curvature: np.ndarray


class Followed(NamedTuple):
    """A linearisation, and per lane where its motion arrives at the sample after its last: displacement,
    velocity, friction force (lanes, 3), with derivatives (lanes, 3, unknowns + 3)."""

    linear: Linearisation
    end: np.ndarray
    end_jacobian: np.ndarray


class Misfit:
    """Residuals of lanes under a hypothesis, linearised lane by lane in one compiled program.

    Lanes go through the program in packs, several at a time on the machine's cores; one compilation serves
    any number of lanes, starts and data sets.
    """

    def __init__(self, hypothesis: Hypothesis, unknowns: Unknowns, *, workers: int):
        self.unknowns = unknowns
        self._hypothesis = jax.tree.map(np.asarray, hypothesis)
        self._chart = unknowns.chart()
        self.workers = workers
        self._last: Any = None, None

    def linearise(self, lanes: Lanes, coordinates: np.ndarray, starts: np.ndarray) -> Linearisation:
        """Cost, gradient, curvature of every lane; `coordinates` (lanes, unknowns), `starts` (lanes, 3)."""
        return self.follow(lanes, coordinates, starts).linear

    def follow(self, lanes: Lanes, coordinates: np.ndarray, starts: np.ndarray) -> Followed:
        """The linearisation of every lane and where its motion arrives, for lanes laid out with at least one
        sample more than count."""
        cost, gradient, curvature, end, slope = self._in_packs(_follow, lanes, coordinates, starts)
        return Followed(Linearisation(cost, gradient, curvature), end, slope)

    def predict(
        self, lanes: Lanes, coordinates: np.ndarray, starts: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Predicted displacement and friction of every lane, each (lanes, samples)."""
        reach = lanes.displacement.shape[1]
        displacement, friction = self._in_packs(_predict, lanes, coordinates, starts)
        return displacement[:, :reach], friction[:, :reach]

    def scores(
        self, lanes: Lanes, coordinates: np.ndarray, starts: np.ndarray, blocks: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """J'r and J'J of the unknowns, the starts eliminated, summed over each of `blocks` equal blocks of
        samples of every lane: (lanes blocks, p) and (lanes blocks, p, p)."""
        each = np.broadcast_to(coordinates, (len(lanes), len(coordinates)))
        program = functools.partial(_scores, blocks=blocks, room=2 ** math.ceil(math.log2(blocks)))
        score, curvature = (part[:, :blocks] for part in self._in_packs(program, lanes, each, starts))
        p = len(coordinates)
        return score.reshape(-1, p), curvature.reshape(-1, p, p)

    def hypothesis(self, coordinates: np.ndarray) -> Hypothesis:
        """The hypothesis with the unknowns at these coordinates."""
        with jax.enable_x64(True):
            return jax.tree.map(np.asarray, self._chart.insert(self._hypothesis, jnp.asarray(coordinates)))

    def _in_packs(self, program: Callable[..., Any], lanes: Lanes, *arrays: np.ndarray) -> list[np.ndarray]:
        count, pace, roomy = len(lanes), lanes.pace(), self._with_room(lanes)
        pack = max(FEWEST, SAMPLES // roomy.displacement.shape[1])

        def run(first: int) -> tuple[np.ndarray, ...]:
            index = np.minimum(np.arange(first, first + pack), count - 1)
            own = roomy.take(index), pace, *(array[index] for array in arrays)
            with jax.enable_x64(True):
                out = program(self._hypothesis, self._chart, *own)
            return tuple(np.asarray(leaf)[: count - first] for leaf in out)

        with ThreadPoolExecutor(self.workers) as pool:
            packs = list(pool.map(run, range(0, count, pack)))
        return [np.concatenate(parts) for parts in zip(*packs, strict=True)]

    def _with_room(self, lanes: Lanes) -> Lanes:
        """The lanes as the program for lanes of their length takes them; those of the last call are kept."""
        known, roomy = self._last
        if known is not lanes:
            roomy = lanes.filled(_room(lanes.displacement.shape[1]))
            self._last = lanes, roomy
        return roomy


def _room(samples: int) -> int:
    """The room for so many samples."""
    room = next((room for room in ROOMS if room >= samples), ROOMS[-1])
    while room < samples:
        room *= 4
    return room


def _motion(hypothesis: Hypothesis, chart: Chart, lane: Lanes, pace: Pace, point: Array) -> Trajectory:
    """The motion of a lane at its unknowns, followed by its start."""
    n = len(chart.names)
    return lane_motion(lane_oscillator(chart.insert(hypothesis, point[:n]), lane), lane, point[n:], pace)


@functools.partial(jax.jit, compiler_options=QUICKLY)
def _follow(
    hypothesis: Hypothesis, chart: Chart, lanes: Lanes, pace: Pace, coordinates: Array, starts: Array
) -> tuple[Array, Array, Array, Array, Array]:
    def both(point: Array, lane: Lanes) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        motion = _motion(hypothesis, chart, lane, pace, point)
        values = lane_residual(lane, motion, point[len(chart.names) :]), lane_end(lane, motion)
        return values, values

    points = jnp.concatenate([coordinates, starts], axis=1)
    (jacobian, slope), (value, end) = lane_jacobian(both, points, lanes)

    def one(value: Array, jacobian: Array) -> tuple[Array, Array, Array]:
        return value @ value, value @ jacobian, jacobian.T @ jacobian

    return *jax.vmap(one)(value, jacobian), end, slope


@functools.partial(jax.jit, static_argnames="room", compiler_options=QUICKLY)
def _scores(
    hypothesis: Hypothesis,
    chart: Chart,
    lanes: Lanes,
    pace: Pace,
    coordinates: Array,
    starts: Array,
    *,
    blocks: Array | int,
    room: int,
) -> tuple[Array, Array]:
    n = len(chart.names)
    member = jnp.arange(lanes.displacement.shape[-1]) * blocks // pace.reach
    member = jnp.concatenate([member, member, jnp.zeros(3, member.dtype)])

    def residual(point: Array, lane: Lanes) -> tuple[Array, Array]:
        value = lane_residual(lane, _motion(hypothesis, chart, lane, pace, point), point[n:])
        return value, value

    jacobian, value = lane_jacobian(residual, jnp.concatenate([coordinates, starts], axis=1), lanes)

    def one(value: Array, jacobian: Array) -> tuple[Array, Array]:
        own, of_start = jacobian[:, :n], jacobian[:, n:]
        own = own - of_start @ jnp.linalg.solve(of_start.T @ of_start, of_start.T @ own)
        score = jax.ops.segment_sum(own * value[:, None], member, room)
        return score, jax.ops.segment_sum(own[:, :, None] * own[:, None, :], member, room)

    return jax.vmap(one)(value, jacobian)


@functools.partial(jax.jit, compiler_options=QUICKLY)
def _predict(
    hypothesis: Hypothesis, chart: Chart, lanes: Lanes, pace: Pace, coordinates: Array, starts: Array
) -> tuple[Array, Array]:
    def one(lane: Lanes, coordinates: Array, start: Array) -> tuple[Array, Array]:
        motion = _motion(hypothesis, chart, lane, pace, jnp.concatenate([coordinates, start]))
        return motion.displacement, motion.friction

    return jax.vmap(one)(lanes, coordinates, starts)
