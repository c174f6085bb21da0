"""The screening of all effects: by how much would each lower the misfit, were it let free a little?

A score test (modification index) with the expected change of the strength, at a fitted hypothesis, after the
starts, the constants, the levels and the rig's tolerance have been projected out. Source: Sorbom,
Psychometrika 54 (1989) 371; with clusters as in Boos, The American Statistician 46 (1992) 327.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from scipy.stats import qmc

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.layout import owners, strengths_of
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.refits.scores import Table, places_of, templates_of
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
    only: Collection[str] | None = None,
    own_group: bool = False,
    shapes: Shapes | None = None,
    instead_of: str | None = None,
) -> Screen:
    """Screens every effect that is not part of the fitted hypothesis yet, or `only` such of these, in its
    usual shape and in `shapes`, or in the most promising ones where these are not given; where `own_group`,
    only those of the groups of what is attached to it, for which there are programs already. Beside effects
    that are attached all are seen with one program, else each with its group's (`Sharing.seen`).

    `instead_of`: an effect of the hypothesis that its free unknowns do not count; what it does, to first
    order, is added to what the others have to explain."""
    present = model.free_effects(at.free)
    among = [group for group in model.sharing.groups if not own_group or {*at.point.keys} & {*group}]
    if at.point.keys:
        among = [tuple(key for group in among for key in group)]
    wanted = {*(model.shelf.effects if only is None else only)} - {*present}
    groups = [tuple(key for key in group if key in wanted) for group in among]
    groups = [group for group in groups if group]
    keys = [key for group in groups for key in group]
    places = places_of(model, bench, keys)
    given = _promising_shapes(model, bench, at, groups) if shapes is None else shapes
    others = [
        {key: shape for key, shape in tried.items() if key in keys and key != instead_of} for tried in given
    ]
    points = [_with_shapes(model, at.point.coordinates, tried) for tried in ({}, *others)]
    common, templates = templates_of(model, bench, at, groups, points)
    if instead_of is not None:
        strengths = strengths_of(model, bench, at.point, instead_of)
        common = common.less(templates[0], places[keys.index(instead_of)], strengths)
    tables = [Table(model, bench, at, common, part) for part in templates]
    usual = [_promise(tables[0], key, place, np.zeros(0)) for key, place in zip(keys, places, strict=True)]
    found = []
    for key, place, promise in zip(keys, places, usual, strict=True):
        made = [promise]
        tried = zip(tables[1:], others, strict=True)
        made += [_promise(table, key, place, shape[key]) for table, shape in tried if key in shape]
        made.sort(key=lambda promise: -promise.worth)
        found.append(dataclasses.replace(made[0], second=made[1] if len(made) > 1 else None))
    found.sort(key=lambda promise: -promise.score)
    return Screen(tuple(found), tuple(keys), tuple(usual), tables[0].cosines(places), others)


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
    places = places_of(model, part, keys)
    draws = np.vstack([[0.5, 0.5], qmc.Halton(2, scramble=False).random(SHAPES + 1)[1:]])
    shifts = REACH * (2 * draws - 1)
    tried = [
        {key: _shape(model, key, at.point.coordinates, number, shift) for key in keys}
        for number, shift in enumerate(shifts)
    ]
    tried.append(_read_off(model, part, point, keys))
    moved = [_with_shapes(model, at.point.coordinates, shapes) for shapes in tried]
    common, templates = templates_of(model, part, thin, shaped, moved)
    tables = [Table(model, part, thin, common, whole) for whole in templates]
    best: dict[str, np.ndarray] = {}
    other: dict[str, np.ndarray] = {}
    for key, place in zip(keys, places, strict=True):
        scores = [_promise(table, key, place, np.zeros(0)).worth for table in tables]
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
    x, v, friction = np.moveaxis(columns.states[:, :, :3], 2, 0)
    slide, slide_rate = model.sliding(lanes, x, v)
    beyond = -columns.residual[:, samples : 2 * samples][counts] / weight
    leftover = Leftover(time[counts], slide[counts], slide_rate[counts], friction[counts], beyond)
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


def _promise(table: Table, key: str, place: np.ndarray, shape: np.ndarray) -> Promise:
    information = table.information(place)
    pull = -table.gram[place, -1]
    change = np.linalg.solve(information, pull)
    scale = np.diag(information)
    inflation = float(np.median(np.sum(table.by_lane[:, place] ** 2, axis=0) / scale))
    around, room = table.response[:, -1], table.response[:, place] @ change
    own_around, own_room = table.own[:, :, -1], table.own[:, :, place] @ change
    owner = [number for number, _ in owners(table.model, table.bench, key)]
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
        feasible=bool(np.all((change > 0) | table.model.two_sided(np.array(owner)))),
    )
