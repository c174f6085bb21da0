"""The screening of all effects: by how much would each lower the misfit, were it let free a little?

A score test (modification index) with the expected change of the strength, at a fitted hypothesis, after the
starts, the constants, the levels and the rig's tolerance have been projected out. Source: Sorbom,
Psychometrika 54 (1989) 371; with clusters as in Boos, The American Statistician 46 (1992) 327.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from fitting.diagnosis.bench import Bench, Point
from fitting.diagnosis.layout import Layout, owners, strengths_of
from fitting.diagnosis.model import Job, Model
from fitting.diagnosis.programs import COLUMNS
from fitting.diagnosis.refit import Projection, Refit, chosen_columns, job
from fitting.diagnosis.wander import allowed
from jaxstick.effect import Leftover

SHAPES = 31
REACH = 2.5
"""How far shapes are tried from the typical one, as a logarithm."""
THIN = 6
"""Other shapes are tried on one lane in so many."""
APART = 0.4
"""Shapes that differ by less than this, as a logarithm, are the same."""
FORBIDDEN = 0.1
"""What a strength of a sign that it may not have promises counts by this share: as far from the truth as the
model may be where it is screened, signs may be wrong."""
SEEN = 1e-6
"""A typical size of an effect that moves chi-square by less cannot be seen in these records at all."""
PEAK, EDGES = 4.0, 0.95
"""What a time does to a sample counts up to so many times what it does to one of its edges, this quantile."""


Shapes = Sequence[Mapping[str, np.ndarray]]
"""Sets of shapes, each by the key of the effect: coordinates of what gives it its shape."""


@dataclasses.dataclass(frozen=True)
class Promise:
    """What an effect promises with its shape as given (logarithms, empty for a typical one).

    second: the next best promise, with another shape, where there is one; score: fall of chi-square; change:
    expected strengths, as shares of typical sizes, one that every run has of its own run by run; inflation:
    variance of the score by clusters of lanes over that of white residuals; information: curvature of every
    strength, of all runs together; around, room: by how much the unknowns, in the order of their `Layout`,
    are to move without the effect, and further to make room for it; own_around, own_room: likewise what every
    lane has of its own; feasible: whether the strengths may have the expected signs.
    """

    key: str
    shape: np.ndarray
    score: float
    change: np.ndarray
    inflation: float
    information: np.ndarray
    around: np.ndarray
    room: np.ndarray
    own_around: np.ndarray
    own_room: np.ndarray
    second: Promise | None = None
    feasible: bool = True

    @property
    def worth(self) -> float:
        """What a shape is chosen by: the score, little of it where the strength would have a sign that it may
        not have."""
        return self.score if self.feasible else FORBIDDEN * self.score

    @property
    def can_be_seen(self) -> bool:
        """Whether the effect leaves any trace in these records."""
        return bool(self.information.max() > SEEN)

    @property
    def standing(self) -> float:
        """The score over what scores vary by from lane to lane, as noise does at least."""
        return self.score / max(self.inflation, 1.0)


@dataclasses.dataclass(frozen=True)
class Screen:
    """Promises in the best shapes, the highest score first; those in the usual shapes and the cosines between
    the effects in these (both in the order of `keys`); the shapes besides the usual ones that were tried on
    all lanes."""

    promises: tuple[Promise, ...]
    keys: tuple[str, ...]
    usual: tuple[Promise, ...]
    cosine: np.ndarray
    shapes: Shapes

    @property
    def inflation(self) -> float:
        """By how much scores vary more from lane to lane than white residuals say, for a typical effect."""
        return float(np.median([promise.inflation for promise in self.promises]))

    @property
    def ranked(self) -> list[Promise]:
        """The promises by the better of two places: by score, and by score over its inflation. Where the gap
        is large, scores are high that vary much from lane to lane."""
        robust = sorted(self.promises, key=lambda promise: -promise.standing)
        in_turn = itertools.chain.from_iterable(zip(self.promises, robust, strict=True))
        return list({promise.key: promise for promise in in_turn}.values())


def screen(
    model: Model,
    bench: Bench,
    at: Refit,
    *,
    own_group: bool = False,
    shapes: Shapes | None = None,
    instead_of: str | None = None,
) -> Screen:
    """Screens every effect that is not part of the fitted hypothesis yet, in its usual shape and in `shapes`,
    or in the most promising ones where these are not given; where `own_group`, only those that are attached
    to it already, which needs no further program.

    `instead_of`: an effect of the hypothesis that its free unknowns do not count; what it does, to first
    order, is added to what the others have to explain."""
    present = model.free_effects(at.free)
    among = [group for group in model.groups() if not own_group or set(group) <= set(at.point.keys)]
    groups = [tuple(key for key in group if key not in present) for group in among]
    groups = [group for group in groups if group]
    keys = [key for group in groups for key in group]
    places = _places(model, bench, keys)
    given = _promising_shapes(model, bench, at, groups) if shapes is None else shapes
    others = [
        {key: shape for key, shape in tried.items() if key in keys and key != instead_of} for tried in given
    ]
    points = [_with_shapes(model, at.point.coordinates, tried) for tried in ({}, *others)]
    common, templates = _templates(model, bench, at, groups, points)
    if instead_of is not None:
        strengths = strengths_of(model, bench, at.point, instead_of)
        common = common.less(templates[0], places[keys.index(instead_of)], strengths)
    tables = [_Table(model, bench, at, common, part) for part in templates]
    usual = [tables[0].promise(key, place, np.zeros(0)) for key, place in zip(keys, places, strict=True)]
    found = []
    for key, place, promise in zip(keys, places, usual, strict=True):
        made = [promise]
        tried = zip(tables[1:], others, strict=True)
        made += [table.promise(key, place, shape[key]) for table, shape in tried if key in shape]
        made.sort(key=lambda promise: -promise.worth)
        found.append(dataclasses.replace(made[0], second=made[1] if len(made) > 1 else None))
    found.sort(key=lambda promise: -promise.score)
    return Screen(tuple(found), tuple(keys), tuple(usual), tables[0].cosines(places), others)


def _places(model: Model, bench: Bench, keys: Sequence[str]) -> list[np.ndarray]:
    counts = [len(owners(model, bench, key)) for key in keys]
    ends = np.cumsum(counts)
    return [np.arange(end - count, end) for end, count in zip(ends, counts, strict=True)]


def _with_shapes(model: Model, coordinates: np.ndarray, shapes: Mapping[str, np.ndarray]) -> np.ndarray:
    """The coordinates with these effects in other shapes."""
    moved = coordinates.copy()
    for key, shape in shapes.items():
        moved[model.index(*model.shelf.shapes[key])] = shape
    return moved


def _promising_shapes(model: Model, bench: Bench, at: Refit, groups: Sequence[tuple[str, ...]]) -> Shapes:
    """The best shape of every effect that has one, and the best that is quite another, tried on a part of the
    lanes: scattered ones, and one that is read off the records. The shapes of all effects change together,
    since an effect at null does not care for another's."""
    shaped = [tuple(key for key in group if model.shelf.shapes[key]) for group in groups]
    shaped = [group for group in shaped if group]
    if not shaped:
        return []
    few = np.arange(0, len(bench.lanes), THIN)
    part = bench.take(few)
    point = at.point.take(few)
    thin = dataclasses.replace(at, point=point, weights=at.weights[few])
    keys = [key for group in shaped for key in group]
    places = _places(model, part, keys)
    draws = np.vstack([[0.5, 0.5], qmc.Halton(2, scramble=False).random(SHAPES + 1)[1:]])
    shifts = REACH * (2 * draws - 1)
    tried = [
        {key: _shape(model, key, at.point.coordinates, number, shift) for key in keys}
        for number, shift in enumerate(shifts)
    ]
    tried.append(_read_off(model, part, point, keys))
    moved = [_with_shapes(model, at.point.coordinates, shapes) for shapes in tried]
    common, templates = _templates(model, part, thin, shaped, moved)
    tables = [_Table(model, part, thin, common, whole) for whole in templates]
    best: dict[str, np.ndarray] = {}
    other: dict[str, np.ndarray] = {}
    for key, place in zip(keys, places, strict=True):
        scores = [table.promise(key, place, np.zeros(0)).worth for table in tables]
        best[key] = tried[int(np.argmax(scores))][key]
        apart = [float(np.max(np.abs(shapes[key] - best[key]))) > APART for shapes in tried]
        if any(apart):
            other[key] = tried[int(np.argmax(np.where(apart, scores, -np.inf)))][key]
    return [best, other]


def _read_off(model: Model, bench: Bench, point: Point, keys: Sequence[str]) -> dict[str, np.ndarray]:
    """The shapes of effects as what a hypothesis leaves of the friction force suggests them, usual ones where
    it does not."""
    (columns,) = model.columns([job(model, bench, point)])
    lanes, samples = bench.lanes, bench.share.shape[1]
    counts = bench.share[:, :, 1] > 0
    weight = np.asarray(lanes.friction_weight)[counts]
    time = np.asarray(lanes.start_time)[:, None] + np.arange(samples) * np.asarray(lanes.interval)[:, None]
    x, v, friction = (columns.states[:, :, place][counts] for place in range(3))
    beyond = -columns.residual[:, samples : 2 * samples][counts] / weight
    leftover = Leftover(time[counts], x, v, friction, beyond)
    found = {}
    for key in keys:
        names = model.shelf.shapes[key]
        own = model.index(*names)
        suggested = model.shelf.effects[key].read_off(leftover)
        shape = point.coordinates[own].copy()
        for place, name in enumerate(names):
            if (value := suggested.get(name.partition(".")[2])) is not None:
                shape[place] = model.members[own[place]].to_coordinate(value)
        found[key] = np.clip(shape, model.lower[own], model.upper[own])
    return found


def _shape(model: Model, key: str, coordinates: np.ndarray, number: int, shift: np.ndarray) -> np.ndarray:
    """The shape of an effect in a trial: its typical one moved by the shift, or in turn what a parameter is
    likely to be on any rig."""
    own = model.index(*model.shelf.shapes[key])
    wanted = coordinates[own] + shift[np.arange(len(own)) % 2]
    for place, name in enumerate(model.shelf.shapes[key]):
        if name in model.tries:
            choices = model.tries[name]
            wanted[place] = model.members[own[place]].to_coordinate(choices[number % len(choices)])
    return np.clip(wanted, model.lower[own], model.upper[own])


class _Seen(NamedTuple):
    """Columns of every lane (lanes, rows, columns), weighted and with the lane's own projected out, and how
    the lane's own answers to them (lanes, own, columns)."""

    columns: np.ndarray
    answer: np.ndarray

    def less(self, other: _Seen, place: np.ndarray, amounts: np.ndarray) -> _Seen:
        """The same without so much of some columns of another in the last column."""
        made = _Seen(self.columns.copy(), self.answer.copy())
        for mine, theirs in zip(made, other, strict=True):
            mine[:, :, -1] -= theirs[:, :, place] @ amounts
        return made


def _templates(
    model: Model, bench: Bench, at: Refit, groups: Sequence[tuple[str, ...]], points: Sequence[np.ndarray]
) -> tuple[_Seen, list[_Seen]]:
    """Level, base unknowns and residual per lane (1 + base + 1 columns), and for every point the columns of
    all strengths."""
    count, deviation = len(bench.lanes), allowed(bench.lanes, at.point.widths)
    every = np.tile(np.arange(count), len(points))
    jobs = [job(model, bench, at.point, chosen_columns(at.free, model.level, count))]
    asked: list[np.ndarray] = []
    for group in groups:
        wanted = np.concatenate([model.index(*model.shelf.strengths[key]) for key in group])
        for first in range(0, len(wanted), COLUMNS):
            few = wanted[first : first + COLUMNS]
            chosen = np.pad(few, (0, COLUMNS - len(few)), constant_values=-1)
            each = np.repeat(points, count, axis=0)
            each[:, model.by_run] = at.point.by_run[np.tile(bench.run, len(points))]
            attached = model.together(at.point.keys, *group)
            own, chosen = at.point.own[every], np.tile(chosen, (len(every), 1))
            jobs.append(Job(attached, bench.lanes, deviation[every], each, own, chosen, bench.whitener))
            asked.append(few)
    base, *others = model.columns(jobs)
    project = Projection(base)
    root = np.sqrt(at.weights)[:, None, None]

    def seen(columns: np.ndarray) -> _Seen:
        return _Seen(project(columns * root), project.answer(columns))

    unknowns = base.jacobian[:, :, : 1 + len(at.free)]
    common = seen(np.concatenate([unknowns, base.residual[:, :, None]], axis=2))
    templates = []
    for number in range(len(points)):
        own = slice(number * count, (number + 1) * count)
        columns = [
            column
            for other, few in zip(others, asked, strict=True)
            for column in _run_by_run(model, bench, few, bounded(model, few, other.jacobian[own]))
        ]
        templates.append(seen(np.concatenate(columns, axis=2)))
    return common, templates


def bounded(model: Model, numbers: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
    """The columns of strengths (lanes, rows, ..), those of times without their peaks: a jump of the force
    within one step, shifted in time, would outweigh all that is to be seen elsewhere."""
    lasting = [place for place, number in enumerate(numbers.tolist()) if model.members[number].unit == "s"]
    if not lasting:
        return jacobian
    seen = jacobian.copy()
    for place in lasting:
        size = np.abs(jacobian[:, :, place])
        most = PEAK * np.quantile(size[size > 0], EDGES) if np.any(size > 0) else 0.0
        seen[:, :, place] = np.clip(jacobian[:, :, place], -most, most)
    return seen


def _run_by_run(model: Model, bench: Bench, numbers: np.ndarray, jacobian: np.ndarray) -> list[np.ndarray]:
    """The columns (lanes, rows, ..) of strengths, one that every run has of its own as a column for each."""
    mine = (bench.run[:, None] == np.unique(bench.run))[:, None, :]
    return [
        jacobian[:, :, [place]] * (mine if number in model.by_run else 1.0)
        for place, number in enumerate(numbers.tolist())
    ]


class _Table:
    """Products of the strengths' columns with one another and with the residual, the base eliminated."""

    def __init__(
        self,
        model: Model,
        bench: Bench,
        at: Refit,
        common: _Seen,
        templates: _Seen,
    ) -> None:
        self.model, self.bench = model, bench
        base = common.columns[:, :, :-1]
        own = base.transpose(0, 2, 1)
        wanted = np.concatenate([templates.columns, common.columns[:, :, -1:]], axis=2)
        across = own @ wanted
        layout = Layout.of(model, bench, at.free)
        coupling, curvature = layout.summed(bench.run, across, own @ base)
        prior = layout.prior(model, at.point)
        coupling[:, -1] += prior.gradient
        curvature += prior.curvature
        curvature += np.diag(1e-12 * np.diag(curvature) + 1e-30)
        slope = np.linalg.solve(curvature, coupling)
        products = wanted.transpose(0, 2, 1) @ wanted
        self.gram = products.sum(0) - coupling.T @ slope
        self.response = -slope
        mine = self.response[layout.index[bench.run]]
        self.own = np.concatenate([templates.answer, common.answer[:, :, -1:]], axis=2)
        self.own = self.own + np.einsum("lob,lbe->loe", common.answer[:, :, :-1], mine)
        by_lane = products[:, :, -1] - np.einsum(
            "lc,lce->le", across[:, :, -1], slope[layout.index[bench.run]]
        )
        self.by_lane = by_lane[:, :-1]

    def promise(self, key: str, place: np.ndarray, shape: np.ndarray) -> Promise:
        information = self.gram[np.ix_(place, place)]
        information = information + np.diag(1e-9 * np.diag(information) + 1e-30)
        pull = -self.gram[place, -1]
        change = np.linalg.solve(information, pull)
        scale = np.diag(information)
        inflation = float(np.median(np.sum(self.by_lane[:, place] ** 2, axis=0) / scale))
        around, room = self.response[:, -1], self.response[:, place] @ change
        own_around, own_room = self.own[:, :, -1], self.own[:, :, place] @ change
        owner = [number for number, _ in owners(self.model, self.bench, key)]
        of_strength = np.array([scale[np.equal(owner, number)].sum() for number in dict.fromkeys(owner)])
        return Promise(
            key,
            shape,
            float(pull @ change),
            change,
            inflation,
            of_strength,
            around,
            room,
            own_around,
            own_room,
            feasible=bool(np.all((change > 0) | self.model.two_sided(np.array(owner)))),
        )

    def cosines(self, places: Sequence[np.ndarray]) -> np.ndarray:
        """The largest cosine between any combinations of two effects' columns (canonical correlation)."""
        roots = []
        for place in places:
            value, vector = np.linalg.eigh(self.gram[np.ix_(place, place)])
            keep = value > 1e-9 * max(value.max(), 1e-300)
            roots.append(vector[:, keep] / np.sqrt(value[keep]))
        out = np.eye(len(places))
        for i, one in enumerate(places):
            for j, other in enumerate(places[:i]):
                across = roots[i].T @ self.gram[np.ix_(one, other)] @ roots[j]
                largest = np.linalg.svd(across, compute_uv=False).max(initial=0.0)
                out[i, j] = out[j, i] = min(float(largest), 1.0)
        return out
