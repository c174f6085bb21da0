"""How friction wanders: no rig rubs with quite the same force twice.

In every lane the whole friction law is multiplied by exp(a + b s), s going from -1 to 1 along the lane, with
a and b drawn from normal distributions around zero: random effects, whose standard deviations are found by
restricted maximum likelihood. Source: Laird, Ware, Biometrics 38 (1982) 963.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from fitting.diagnosis.lanes.steadiness import Levels
from fitting.lanes import Lanes
from jaxstick.oscillator import Oscillator
from jaxstick.parts.friction import AbstractFriction
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.scaled_friction import AbstractScaledFriction

START = 3
"""Displacement, velocity and friction force at a lane's beginning."""
OWN = START + 2
"""What every lane has of its own: its start, level and slope of its friction."""
LEAST = 1e-6
WIDTHS = np.concatenate([[LEAST], np.geomspace(1e-5, 0.3, 40)])
"""Standard deviations that are tried: the first stands for none at all."""
SETTLED = 4.0
"""Lanes whose cost lies so many times above the typical one do not say how friction wanders,"""
FAR_OFF = 5.0
"""nor do lanes whose level or slope lies so many standard deviations from none: an event that was lost can be
made good by a level that is far off."""
RIDGE = 1e-12
"""Keeps apart what a lane has of its own where its motion tells nearly nothing apart."""
NARROWER = 10.0
"""A standard deviation narrows to no less than what lanes have at the time over this: what they have would
else cost more than all they could lose by a step that leads astray."""
MEDIAN_SQUARE = 0.455
"""The median of the square of a standard normal variable."""


class Wandering(AbstractScaledFriction):
    """The law `inner` times exp(level + slope s), s from -1 to 1 between two times."""

    inner: AbstractFriction
    level: Scalar
    slope: Scalar
    middle: Scalar
    half: Scalar

    def excess(self, motion: Motion) -> Scalar:
        return jnp.expm1(self.level + self.slope * (motion.t - self.middle) / self.half)


def wandering(oscillator: Oscillator, lane: Lanes, level: Scalar, slope: Scalar) -> Oscillator:
    """The oscillator of a lane with its friction so changed."""
    counts = jnp.asarray(lane.displacement_weight) > 0
    interval = jnp.asarray(lane.interval)
    first, number = (count.astype(interval.dtype) for count in (jnp.argmax(counts), jnp.sum(counts)))
    half = jnp.maximum(number - 1, 1) * interval / 2
    middle = jnp.asarray(lane.start_time) + first * interval + half
    friction = Wandering(oscillator.friction, level, slope, middle, half)
    return eqx.tree_at(lambda whole: whole.friction, oscillator, friction)


def with_room(lanes: Lanes) -> Lanes:
    """Lanes whose start has room for level and slope of friction, none of which may differ from zero yet."""
    start, deviation = np.asarray(lanes.start), np.asarray(lanes.start_deviation)
    blank = np.zeros((len(start), OWN - START))
    return dataclasses.replace(
        lanes,
        start=np.concatenate([start, blank], axis=1),
        start_deviation=np.concatenate([deviation, blank + LEAST], axis=1),
    )


def allowed(lanes: Lanes, widths: np.ndarray) -> np.ndarray:
    """Standard deviations (lanes, 5) of what lanes have of their own where friction may wander by these of
    level and slope."""
    deviation = np.array(lanes.start_deviation)
    deviation[:, START:] = widths
    return deviation


class Likeliest(NamedTuple):
    """Standard deviations of level and slope where residuals are as large as the noise (they grow with its
    root), twice the logarithm of what they cost in likelihood, and the levels that tell them."""

    widths: np.ndarray
    price: float
    levels: Levels


def likeliest(
    own: np.ndarray, gradient: np.ndarray, curvature: np.ndarray, widths: np.ndarray, share: np.ndarray
) -> Likeliest:
    """The likeliest standard deviations of level and slope.

    own (lanes, 5); J'r and J'J of what each lane has of its own, prior included, with `widths` as they have
    been; share: cost of every lane per degree of freedom.
    """
    typical = float(np.median(share))
    settled = share < SETTLED * typical
    noise = float(np.mean(share[settled]))
    found, price, known = np.empty(OWN - START), 0.0, []
    for number in range(OWN - START):
        place = START + number
        rest = np.array([i for i in range(OWN) if i != place])
        precision = widths[number] ** -2.0
        across = curvature[:, place, rest]
        within = curvature[:, rest][:, :, rest] * (1 + RIDGE * np.eye(OWN - 1))
        solved = np.linalg.solve(within, np.stack([across, gradient[:, rest]], axis=2))
        information = curvature[:, place, place] - precision - np.einsum("lr,lr->l", across, solved[:, :, 0])
        pull = gradient[:, place] - precision * own[:, place] - np.einsum("lr,lr->l", across, solved[:, :, 1])
        information = np.maximum(information, 1e-12)
        best = own[:, place] - pull / information
        near = settled & _near(best, noise / information)
        variance = WIDTHS[:, None] ** 2 * noise + noise / information[near]
        cost = np.sum(np.log(variance) + best[near] ** 2 / variance, axis=1)
        wandered = math.sqrt(_typical_square(own[:, place]))
        cost[min(wandered / NARROWER, widths[number]) > WIDTHS] = np.inf
        chosen = int(np.argmin(cost))
        found[number] = WIDTHS[chosen]
        price += float(np.sum(np.log1p(WIDTHS[chosen] ** 2 * information)))
        known.append(Levels(best, noise / information, near))
    return Likeliest(found, price, known[0])


def _near(values: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Which values, each known to within its variance, are no outliers of a normal one around zero."""
    return values**2 <= FAR_OFF**2 * (_typical_square(values) + variance)


def _typical_square(values: np.ndarray) -> float:
    """The variance of a normal distribution around zero as the median square of values tells it, which
    outliers hardly touch."""
    return float(np.median(values**2)) / MEDIAN_SQUARE
