"""Lanes caught on the wrong side of an event are freed: each settled by itself, and what is still lost again
from where the lane before it passes by, or from many starts."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.cost import whole_cost
from fitting.diagnosis.lanes.equations import fall, normal
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import FAR_OFF, OWN, START
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.search import ENOUGH

SWEEPS = 4
"""Lost lanes may follow one another."""
TRIES, LEAST_TRIES = 8, 48
"""So many scattered starts for every lane that is still lost, and at least so many together."""
SCATTER = (0.02, 0.3, 1.0)
"""Standard deviations of displacement, velocity and force of the new starts, in units of their priors'."""
WIDER = 3.0
"""Every other new start lies so many times as far off: where a run begins, velocity is read off one side."""
ITERATIONS = 5
SUSPECT = 4.0
MANY = 0.2
"""Where more than this share of the lanes is lost, the model is wrong rather than its starts."""
BETTER = 0.9
TURNS = 2
LEAST_GAIN = 1e-3
"""What lanes have to gain by settling each by itself, as a share of their cost, for everything to be fitted
once more."""
WORTHWHILE = 0.98
"""What a first turn has to leave of the misfit for there to be a second one."""
A_LITTLE = 1e-3
"""Friction that wanders by as little has lost no event."""


def released(model: Model, bench: Bench, fit: Refit, seed: int = 0, *, wander: bool = True) -> Refit:
    """The refit with its lost lanes freed and everything fitted once more, and once again where that has
    helped; the same where none is better, or where no more was to be had before.

    At the unknowns as they are, every lane settles by itself: a search takes or leaves the steps of all lanes
    together, so that a few at an event hold up the others. Each that is lost then goes on where the lane
    before it passes by, or else starts again from points scattered around what the record says.
    """
    if fit.freed:
        return fit
    for turn in range(TURNS):
        before, found = fit.misfit, _released(model, bench, fit, seed + turn, wander)
        if found.misfit < before:
            fit = found
        if not found.misfit < WORTHWHILE * before:
            return dataclasses.replace(fit, freed=True)
    return fit


def _released(model: Model, bench: Bench, fit: Refit, seed: int, wander: bool) -> Refit:
    own, cost = fit.point.own.copy(), fit.cost.copy()
    alone = settled(model, bench, fit.point)
    gain = alone.before - alone.cost
    if gain.sum() > LEAST_GAIN * alone.before.sum():
        own, cost = alone.own.copy(), np.where(gain > 0, alone.cost, cost)
    lost = _lost(bench, dataclasses.replace(fit, cost=cost))

    def tried(some: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """Settles starts (tries, lanes, 5) of some lanes, takes those that are better, and says which lanes
        have none."""
        tries, count = len(begin), len(some)
        part = bench.take(np.tile(some, tries))
        found, costs, _ = settled(model, part, dataclasses.replace(fit.point, own=begin.reshape(-1, OWN)))
        best = np.argmin(costs.reshape(tries, count), axis=0) * count + np.arange(count)
        better = costs[best] < BETTER * cost[some]
        own[some[better]], cost[some[better]] = found[best[better]], costs[best[better]]
        return some[~better]

    left = lost
    for _ in range(SWEEPS):
        if not len(left):
            break
        handed, known = handed_on(model, bench, dataclasses.replace(fit.point, own=own), left)
        if not known.any():
            break
        still = tried(left[known], handed[None, known])
        if len(still) == known.sum():
            break
        left = np.union1d(left[~known], still)
    if 0 < len(left) <= MANY * len(bench.lanes):
        tries = max(TRIES, LEAST_TRIES // len(left))
        random = np.random.default_rng(seed)
        begin = np.tile(np.asarray(bench.lanes.start)[left], (tries, 1, 1))
        deviation = np.asarray(bench.lanes.start_deviation)[left, :START]
        scatter = random.standard_normal((tries, len(left), START))
        far = np.where(np.arange(tries) % 2 == 0, 1.0, WIDER)[:, None, None]
        begin[:, :, :START] += far * np.array(SCATTER) * deviation * scatter
        tried(left, begin)
    if np.array_equal(own, fit.point.own):
        return fit
    (again,) = refit(model, bench, [dataclasses.replace(fit.point, own=own)], [fit.free], wander=wander)
    return again


def _lost(bench: Bench, fit: Refit) -> np.ndarray:
    """The lanes whose cost lies far above the typical one, and those whose friction has wandered far off."""
    share = fit.cost / bench.dof()
    typical = float(np.median(share))
    dear = share > max(SUSPECT * typical, typical * (1 + 6 * np.sqrt(2 / bench.dof().mean())))
    widths = np.maximum(fit.point.widths * np.sqrt(typical), A_LITTLE)
    strayed = np.abs(fit.point.own[:, START:]) > FAR_OFF * widths
    return np.flatnonzero(dear | strayed.any(1))


def handed_on(model: Model, bench: Bench, point: Point, lost: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What lost lanes would have of their own if each went on where the lane before it passes by (lost, 5),
    and for which of them that is known."""
    lanes, before = bench.lanes, np.maximum(lost - 1, 0)
    interval, begin = np.asarray(lanes.interval)[lost], np.asarray(lanes.start_time)
    place = np.rint((begin[lost] - begin[before]) / interval).astype(int)
    samples = lanes.displacement.shape[1]
    within = (place > 0) & (place < samples) & (bench.run[before] == bench.run[lost])
    part, own = bench.take(before), point.own[before]
    (columns,) = model.columns([job(model, part, dataclasses.replace(point, own=own))])
    state = columns.states[np.arange(len(lost)), np.where(within, place, 0)]
    level = own[:, START] + own[:, START + 1]
    return np.column_stack([state, level, np.zeros(len(lost))]), within


def borrowed(model: Model, bench: Bench, fit: Refit, other: Refit, near: float = 1.0) -> Refit:
    """The refit, fitted once more with the starts that another hypothesis has for the lanes that it fits far
    better, and with all of them and its constants; the same where neither is better, or where the other
    leaves no less than the share `near` of its misfit."""
    if other.misfit >= near * fit.misfit:
        return fit
    lost = fit.cost > SUSPECT * other.cost
    own = np.where(lost[:, None], other.point.own, fit.point.own)
    common = model.index(*model.common)
    coordinates = fit.point.coordinates.copy()
    coordinates[common] = other.point.coordinates[common]
    by_run = fit.point.by_run.copy()
    by_run[:, 0] = other.point.by_run[:, 0]
    points = [
        dataclasses.replace(fit.point, own=own),
        dataclasses.replace(
            fit.point,
            coordinates=coordinates,
            by_run=by_run,
            own=other.point.own,
            widths=other.point.widths,
        ),
    ]
    reached = fit.misfit * float(bench.dof().sum())
    again = refit(model, bench, points, [fit.free, fit.free], hopeless=1.0, reached=reached)
    return min([fit, *again], key=lambda one: one.misfit)


class Settled(NamedTuple):
    """What is best for every lane by itself (lanes, 5), its cost, and what it cost before."""

    own: np.ndarray
    cost: np.ndarray
    before: np.ndarray


def settled(model: Model, bench: Bench, point: Point, iterations: int = ITERATIONS) -> Settled:
    """What is best for every lane by itself at given unknowns; a lane is left where its next step promises
    next to nothing, of its cost or of what noise costs: one far astray has long to go in small steps."""
    own, damping = point.own.copy(), np.full(len(bench.lanes), 1e-3)
    gradient, curvature, cost = _own_terms(model, bench, point)
    before, part, going = cost.copy(), bench, np.arange(len(bench.lanes))
    noise = bench.dof()
    for _ in range(iterations):
        g, h = gradient[going], curvature[going]
        damped = h * (1 + damping[going, None, None] * np.eye(OWN))
        step = -np.linalg.solve(damped, g[:, :, None])[:, :, 0]
        worth = fall(g, h, step) > ENOUGH * np.minimum(cost, noise)[going]
        if not worth.any():
            break
        if not worth.all():
            going, step, part = going[worth], step[worth], part.take(np.flatnonzero(worth))
        trial = own[going] + step
        found = _own_terms(model, part, dataclasses.replace(point, own=trial))
        better = found[2] < cost[going]
        taken = going[better]
        own[taken], cost[taken] = trial[better], found[2][better]
        gradient[taken], curvature[taken] = found[0][better], found[1][better]
        damping[going] = np.clip(np.where(better, 0.1, 8.0) * damping[going], 1e-9, 1e9)
    return Settled(own, cost, before)


def all_settled(model: Model, bench: Bench, points: Sequence[Point]) -> list[Point]:
    """The points, each with what is best for every lane by itself."""

    def one(point: Point) -> Point:
        return dataclasses.replace(point, own=settled(model, bench, point).own)

    return model.side_by_side(one, points)


def _own_terms(model: Model, bench: Bench, point: Point) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    (columns,) = model.columns([job(model, bench, point)])
    gradient, curvature = normal(columns)
    return gradient[:, -OWN:], curvature[:, -OWN:, -OWN:], whole_cost(columns)
