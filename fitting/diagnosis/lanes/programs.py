"""The compiled programs of a diagnosis: residuals of lanes with their derivatives, and predictions.

They stand apart from what uses them, so that programs kept from another day serve until the code of the
programs themselves changes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array

from fitting.diagnosis.lanes.wander import OWN, START, wandering
from fitting.lanes import Lanes, Pace, lane_motion, lane_oscillator, lane_residual
from fitting.unknowns import Chart
from jaxstick.compiled import QUICKLY, has_wide_vectors, lane_jacobian
from jaxstick.hypothesis import Hypothesis
from jaxstick.simulate import Trajectory
from jaxstick.traced import traced

COLUMNS = 15
"""How many unknowns the program takes derivatives for at once, besides what a lane has of its own."""


OPTIONS = QUICKLY if has_wide_vectors() else {**QUICKLY, "xla_cpu_prefer_vector_width": "256"}
"""Where lanes fill no wide vectors, these run no faster and compile by a tenth slower; a diagnosis has many
programs."""


class Pack(NamedTuple):
    """What a program is run on: lanes with room, its pace, and for every lane coordinates, what it has of its
    own, and the places among the coordinates of what it is differentiated by."""

    lanes: Lanes
    pace: Pace
    coordinates: Any
    own: Any
    chosen: Any


def _motion(
    hypothesis: Hypothesis, chart: Chart, lane: Lanes, pace: Pace, coordinates: Array, own: Array
) -> Trajectory:
    """The motion along a lane, its friction wandering around the run's level, the last coordinate."""
    oscillator = lane_oscillator(chart.insert(hypothesis, coordinates[:-1]), lane)
    oscillator = wandering(oscillator, lane, coordinates[-1] + own[START], own[START + 1])
    return lane_motion(oscillator, lane, own[:START], pace)


@traced(OPTIONS)
def columns(hypothesis: Hypothesis, chart: Chart, pack: Pack) -> tuple[Array, Array, Array]:
    """Residuals of lanes (lanes, rows) in standard deviations; their derivatives (lanes, rows, columns + 5)
    by the chosen unknowns and by what each lane has of its own; and the motion itself (lanes, samples, 3):
    displacement, velocity, friction force as they are, not as sensors read them."""

    def residual(
        step: Array, lane: Lanes, point: Array, own: Array, wanted: Array
    ) -> tuple[Array, tuple[Array, Array]]:
        moved = point.at[wanted].add(jnp.where(wanted >= 0, step[:COLUMNS], 0.0))
        mine = own + step[COLUMNS:]
        motion = _motion(hypothesis, chart, lane, pack.pace, moved, mine)
        value = lane_residual(lane, motion, mine)
        return value, (value, jnp.stack([motion.x, motion.v, motion.force], axis=1))

    steps = jnp.zeros((len(pack.own), COLUMNS + OWN))
    jacobian, (value, states) = lane_jacobian(
        residual, steps, pack.lanes, pack.coordinates, pack.own, pack.chosen
    )
    return value, jacobian, states


@traced(OPTIONS)
def prediction(hypothesis: Hypothesis, chart: Chart, pack: Pack) -> tuple[Array, Array, Array, Array]:
    """Displacement and friction as read, true velocity and friction of every lane, (lanes, samples)."""

    def one(lane: Lanes, point: Array, own: Array) -> tuple[Array, Array, Array, Array]:
        motion = _motion(hypothesis, chart, lane, pack.pace, point, own)
        return motion.displacement, motion.friction, motion.v, motion.force

    return jax.vmap(one)(pack.lanes, pack.coordinates, pack.own)
