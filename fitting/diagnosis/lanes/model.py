"""The nominal model with effects of the shelf attached, and the residuals of lanes as functions of all that
may be free: one compiled program for a whole group of effects."""

from __future__ import annotations

import collections
import contextlib
import dataclasses
import math
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from fitting.diagnosis.lanes.columns import Columns
from fitting.diagnosis.lanes.freedom import contact_unknowns, effect_unknown, rig_unknowns
from fitting.diagnosis.lanes.programs import COLUMNS, columns, prediction
from fitting.diagnosis.lanes.roomy import Roomy
from fitting.diagnosis.lanes.sharing import Sharing
from fitting.diagnosis.lanes.wander import OWN
from fitting.lanes import Lanes
from fitting.problem import Problem
from fitting.unknowns import RIG, Chart, Unknown
from jaxstick.catalogue import catalogue
from jaxstick.effect import AbstractEffect
from jaxstick.hypothesis import Hypothesis, effects_at_null
from jaxstick.parameter import parameters
from jaxstick.parts.drive import Excitation

PACK = 16
"""So many lanes go through a program together: with more, small data sets fill packs with lanes that do not
count; with fewer, all take longer."""
KEPT = 16
"""So many benches' lanes are kept as programs take them."""
LEVEL_TOLERANCE = 0.15
"""By what share the friction of one run may differ from the others' (one standard deviation)."""


@dataclasses.dataclass(frozen=True)
class Shelf:
    """The effects as candidates: their keys, which unknowns are strengths and which give the shape, and the
    traces that they leave in the channels that were recorded."""

    effects: dict[str, type[AbstractEffect]]
    strengths: dict[str, tuple[str, ...]]
    shapes: dict[str, tuple[str, ...]]
    traces: dict[str, tuple[str, ...]]

    def names(self, key: str) -> tuple[str, ...]:
        return (*self.strengths[key], *self.shapes[key])

    def of_friction(self, keys: Iterable[str] | None = None) -> tuple[str, ...]:
        """Those of some effects, by default of all, that change friction."""
        among = self.effects if keys is None else keys
        return tuple(key for key in among if self.effects[key].card.family == "friction")

    def titled(self, key: str) -> str:
        """An effect by its key and, in parentheses, its title."""
        title = self.effects[key].card.title
        return f"{key} ({title[0].lower()}{title[1:]})"


class Prediction(NamedTuple):
    """What lanes show (lanes, samples): displacement [m] and friction [N] as they are read, the true velocity
    [m/s] and the true friction force [N]."""

    displacement: np.ndarray
    friction: np.ndarray
    velocity: np.ndarray
    force: np.ndarray


class Job(NamedTuple):
    """Lanes to be linearised with some effects attached, once or several times, one time after the other.

    keys: the effects; of the measuring chain's the last stands nearest to the contact. deviation (times
    lanes, 5): standard deviations of the priors of what lanes have of their own; coordinates (times lanes,
    all); own (times lanes, 5); chosen (times lanes, some times `COLUMNS`), the numbers of the unknowns that
    each lane is differentiated by, -1 for none. whitener: `Bench.whitener` of the lanes.
    """

    keys: tuple[str, ...]
    lanes: Lanes
    deviation: np.ndarray
    coordinates: np.ndarray
    own: np.ndarray
    chosen: np.ndarray
    whitener: np.ndarray | None = None

    def parts(self) -> list[Job]:
        """The jobs, each for as many unknowns as the program takes at once, that do what this one asks."""
        whole = range(0, self.chosen.shape[1], COLUMNS)
        return [self._replace(chosen=self.chosen[:, first : first + COLUMNS]) for first in whole]


Rows = Callable[[int, int], Sequence[Sequence[slice]]]
"""Which rows of every array count, given how many samples lanes have and for how many there is room."""
In = TypeVar("In")
Out = TypeVar("Out")


class Model:
    """Every parameter that a diagnosis may free, and the residuals of lanes as a function of them.

    A coordinate of an effect's strength is the strength over its typical size, as is that of a shape that may
    have either sign; that of another shape is its logarithm.
    `constants` are those of friction; `common` what is free under every hypothesis: these, the rig within its
    tolerance, and what gives the contact its shape. The last coordinate is the logarithm of the level of
    friction in a run: it multiplies A, C and D of the lanes of that run. `by_run` are the numbers of what
    every run has of its own: the level, and what an effect has anew in every run.
    """

    def __init__(self, problem: Problem, workers: int) -> None:
        held = {key: problem.hypothesis.effects[key] for key in problem.hypothesis.order}
        shelf = {key: effect for key, effect in catalogue().items() if key not in held}
        self.nominal = jax.tree.map(np.asarray, problem.hypothesis.nominal)
        effects = effects_at_null(tuple(shelf))
        strengths, shapes, members = {}, {}, list(problem.unknowns.members)
        self.tries: dict[str, tuple[float, ...]] = {}
        by_run: list[str] = []
        parts: list[str] = []
        self.constants = tuple(unknown.name for unknown in members)
        members += [*rig_unknowns(problem), *contact_unknowns(problem)]
        self.common = tuple(unknown.name for unknown in members)
        for key, effect in effects.items():
            places = list(parameters(effect))
            own = [effect_unknown(f"{key}.{place.path[-1]}", effect, place, problem) for place in places]
            kinds = {u.name: place.parameter for u, place in zip(own, places, strict=True)}
            strengths[key] = tuple(name for name, kind in kinds.items() if kind.null is not None)
            shapes[key] = tuple(
                name for name, kind in kinds.items() if kind.null is None and (kind.typical or kind.tries)
            )
            self.tries.update({name: kind.tries for name, kind in kinds.items() if kind.tries})
            by_run += [name for name in (*strengths[key], *shapes[key]) if kinds[name].by_run]
            unstated = {u.name: float(place.of(effect)) for u, place in zip(own, places, strict=True)}
            parts += [
                u.name for u in own if u.name in shapes[key] and u.kind == "log" and unstated[u.name] == 0
            ]
            members += own
        traces = {key: effect.traces_seen(problem.friction_recorded) for key, effect in shelf.items()}
        self.shelf = Shelf(shelf, strengths, shapes, traces)
        self.sharing = Sharing.of(shelf)
        self._friction_recorded = problem.friction_recorded
        self.parts = frozenset(parts)
        self.members = tuple(members)
        self.names = tuple(unknown.name for unknown in members)
        self.level = len(members)
        self.by_run = np.array([self.level, *self.index(*by_run)])
        self.lower = np.array([*(_bound(u, u.lower) for u in members), -1.0])
        self.upper = np.array([*(_bound(u, u.upper) for u in members), 1.0])
        self.workers = workers
        self._effects = jax.tree.map(np.asarray, effects)
        self._held = {key: jax.tree.map(np.asarray, effect) for key, effect in held.items()}
        self._known: dict[tuple[str, ...], tuple[Hypothesis, Chart, np.ndarray]] = {}
        self._roomy: collections.OrderedDict[int, Roomy] = collections.OrderedDict()
        self._using = threading.Lock()

    def sliding(
        self, lanes: Lanes, displacement: np.ndarray, velocity: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """How far and how fast a mass that moves so slides over its guide (lanes, samples) [m, m/s]."""
        base, rate = (jnp.asarray(each) for each in lanes.base_motion())
        still = jnp.zeros_like(base)
        surface = self.nominal.rig.surface(Excitation(base, rate, still, still))
        return displacement - np.asarray(surface.position), velocity - np.asarray(surface.rate)

    def effect(self, key: str) -> AbstractEffect:
        """An effect of the shelf at null."""
        return self._effects[key]

    def index(self, *names: str) -> np.ndarray:
        """The places of unknowns among the coordinates."""
        return np.array([self.names.index(name) for name in names], int)

    def alike(self, runs: int) -> np.ndarray:
        """What so many runs have of their own where none differs from another and no effect acts."""
        return np.zeros((runs, len(self.by_run)))

    def slots(self, numbers: np.ndarray) -> np.ndarray:
        """The places of unknowns among what every run has of its own."""
        return np.array([self.by_run.tolist().index(number) for number in numbers.tolist()], int)

    def nuisances(self) -> np.ndarray:
        """The places of what is free under every hypothesis."""
        return self.index(*self.common)

    def of_rig(self) -> np.ndarray:
        """The places of what the rig may differ by within its tolerance."""
        return self.index(*(name for name in self.common if name.startswith(RIG)))

    def free_effects(self, free: np.ndarray) -> tuple[str, ...]:
        """The effects that have a parameter among these unknowns."""
        names = {self.names[i].partition(".")[0] for i in free}
        return tuple(key for key in self.shelf.effects if key in names)

    def two_sided(self, numbers: np.ndarray) -> np.ndarray:
        """Which of these strengths may have either sign."""
        return self.lower[numbers] < 0

    def may_show(self, key: str) -> bool:
        """Whether an effect that shows nothing at null may do so at some size: any but a fault of the
        measuring chain where no friction force was recorded, for then it is the force's."""
        return self._friction_recorded or self.shelf.effects[key].card.family != "measurement"

    def lasts(self, key: str) -> bool:
        """Whether the strength of an effect is a time."""
        return all(self.members[n].unit == "s" for n in self.index(*self.shelf.strengths[key]))

    def parts_of_it(self, numbers: np.ndarray) -> np.ndarray:
        """Which of these unknowns say in which part of it another form of an effect acts, and are searched by
        their logarithm, which has no zero."""
        names = [self.names[n] for n in numbers.tolist()]
        return numbers[[name in self.parts for name in names]]

    def of(self, key: str) -> np.ndarray:
        """The places of an effect's unknowns, strengths first."""
        return self.index(*self.shelf.names(key))

    def origin(self, constants: dict[str, float]) -> np.ndarray:
        """Coordinates of the nominal model: these constants, the rig as stated, effects at null and in their
        typical shape."""
        point = np.zeros(len(self.members) + 1)
        for i, unknown in enumerate(self.members):
            value = constants.get(unknown.name, unknown.centre)
            if value is not None:
                point[i] = unknown.to_coordinate(np.clip(value, unknown.lower, unknown.upper))
        return np.clip(point, self.lower, self.upper)

    def prior(self, values: np.ndarray, numbers: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Twice the negative log prior of unknowns, given by their numbers, at these coordinates of theirs;
        half its gradient, half its curvature."""
        members = [self.members[i] for i in numbers]
        centre = np.array([0.0 if u.centre is None else float(u.to_coordinate(u.centre)) for u in members])
        deviation = np.array([math.inf if u.deviation is None else _in_coordinates(u) for u in members])
        miss = (values - centre) / deviation
        return float(miss @ miss), miss / deviation, deviation**-2.0

    def values(self, coordinates: np.ndarray, names: Sequence[str]) -> dict[str, float]:
        """Parameters in their own units."""
        at = self.index(*names)
        return {self.names[i]: float(self.members[i].to_value(coordinates[i])) for i in at}

    def columns(self, jobs: Sequence[Job]) -> list[Columns]:
        """Residuals and derivatives of several jobs, all their packs shared among the cores."""

        def rows(reach: int, room: int) -> Sequence[Sequence[slice]]:
            read = slice(reach), slice(room, room + reach), slice(2 * room, 2 * room + OWN)
            return read, read, [slice(reach)]

        parts = [job.parts() for job in jobs]
        found = iter(self._in_packs(columns, [part for job in parts for part in job], rows))
        whole = [_joined([Columns(*next(found)) for _ in job]) for job in parts]

        def whitened(number: int) -> Columns:
            job = jobs[number]
            return whole[number].whitened(job.whitener, _used(job.chosen))

        return self.side_by_side(whitened, range(len(jobs)))

    def predict(
        self, keys: tuple[str, ...], lanes: Lanes, coordinates: np.ndarray, own: np.ndarray
    ) -> Prediction:
        """What lanes show with some effects attached, at their coordinates and with what they have of their
        own; the arrays are those of `Job`."""
        none = np.full((len(lanes), COLUMNS), -1)
        jobs = [Job(keys, lanes, np.asarray(lanes.start_deviation), coordinates, own, none)]
        (found,) = self._in_packs(prediction, jobs, lambda reach, room: 4 * [[slice(reach)]])
        return Prediction(*found)

    @contextlib.contextmanager
    def ahead(self, lanes: Lanes, groups: Iterable[tuple[str, ...]]) -> Iterator[None]:
        """While the context lasts, the programs that linearise lanes laid out like these with each of these
        groups of effects attached are compiled beside what goes on, on one core, if there are several."""
        one, coordinates = lanes.take(np.zeros(1, int)), self.origin({})[None]
        own, chosen = np.zeros((1, OWN)), np.full((1, COLUMNS), -1)
        pool = ThreadPoolExecutor(1)
        for group in groups if self.workers > 1 else ():
            pool.submit(self.columns, [Job(group, one, np.ones((1, OWN)), coordinates, own, chosen)])
        try:
            yield
        finally:
            pool.shutdown(wait=False, cancel_futures=True)

    def side_by_side(self, function: Callable[[In], Out], items: Iterable[In]) -> list[Out]:
        """The function of every item, on all of the cores that the diagnosis may use."""
        each = list(items)
        if min(self.workers, len(each)) < 2:
            return [function(one) for one in each]
        with ThreadPoolExecutor(self.workers) as pool:
            return list(pool.map(function, each))

    def at(self, coordinates: np.ndarray, keys: tuple[str, ...]) -> Hypothesis:
        """The hypothesis at these coordinates with these effects attached, in this order."""
        hypothesis, chart, own = self._attached(keys)
        with jax.enable_x64(True):
            return jax.tree.map(np.asarray, chart.insert(hypothesis, jnp.asarray(coordinates[own[:-1]])))

    def _attached(self, keys: tuple[str, ...]) -> tuple[Hypothesis, Chart, np.ndarray]:
        """The nominal model with some effects attached at null, in this order, the chart of its unknowns,
        and where those and the level are among all coordinates."""
        if keys not in self._known:
            self._known[keys] = self._attach(keys)
        return self._known[keys]

    def _attach(self, keys: tuple[str, ...]) -> tuple[Hypothesis, Chart, np.ndarray]:
        effects = {**self._held, **{key: self._effects[key] for key in reversed(keys)}}
        hypothesis = Hypothesis(self.nominal, effects)
        own = [
            i for i, name in enumerate(self.names) if name in self.common or name.partition(".")[0] in keys
        ]
        chart = Chart(
            tuple(self.names[i] for i in own),
            tuple(self.members[i].kind == "log" for i in own),
            np.array([self.members[i].scale for i in own]),
        )
        return hypothesis, chart, np.array([*own, self.level])

    def _in_packs(self, program: Any, jobs: Sequence[Job], rows: Rows) -> list[list[np.ndarray]]:
        """What a program gives for the lanes of every job: arrays (lanes, rows, ..), rows that count. Every
        job's first pack goes before any other's second, so that programs compile side by side."""
        tasks = [(n, first) for n, job in enumerate(jobs) for first in range(0, len(job.own), PACK)]
        tasks.sort(key=lambda task: task[1])
        attached = {job.keys: self._attached(job.keys) for job in jobs}

        def run(task: tuple[int, int]) -> tuple[list[np.ndarray], ...]:
            number, first = task
            job = jobs[number]
            hypothesis, chart, own = attached[job.keys]
            place = np.full(len(self.members) + 2, -1)
            place[own] = np.arange(len(own))
            count, roomy = len(job.own), self._with_room(job.lanes)
            index = np.minimum(np.arange(first, first + PACK), count - 1)
            points = (
                job.coordinates[np.ix_(index, own)],
                job.own[index],
                place[job.chosen[index]],
            )
            with jax.enable_x64(True):
                call, constant = roomy.program(program, job.keys, hypothesis, chart, points)
                out = call(*constant, *roomy.taken(index, job.deviation[index]), *roomy.pace, *points)
            kept = zip(out, rows(roomy.reach, roomy.room), strict=True)
            return tuple([np.asarray(leaf)[: count - first, part] for part in parts] for leaf, parts in kept)

        packs = self.side_by_side(run, tasks)
        found: list[list[tuple[list[np.ndarray], ...]]] = [[] for _ in jobs]
        for (number, _), pack in zip(tasks, packs, strict=True):
            found[number].append(pack)
        return [[_whole(parts) for parts in zip(*own, strict=True)] for own in found]

    def _with_room(self, lanes: Lanes) -> Roomy:
        """The lanes as programs take them; those of the last few benches are kept."""
        with self._using:
            known = self._roomy.pop(id(lanes), None) or Roomy(lanes)
            self._roomy[id(lanes)] = known
            while len(self._roomy) > KEPT:
                self._roomy.popitem(last=False)
        return known


def _used(chosen: np.ndarray) -> np.ndarray:
    """Which derivatives are asked for: by the chosen unknowns, and by what each lane has of its own."""
    return np.concatenate([np.flatnonzero((chosen >= 0).any(0)), chosen.shape[1] + np.arange(OWN)])


def _joined(parts: Sequence[Columns]) -> Columns:
    """The derivatives by the unknowns of all parts, and by what each lane has of its own."""
    first, *others = parts
    if not others:
        return first
    unknowns = [part.plain[:, :, :COLUMNS] for part in parts]
    return dataclasses.replace(first, plain=np.concatenate([*unknowns, first.plain[:, :, COLUMNS:]], axis=2))


def _whole(packs: Sequence[Sequence[np.ndarray]]) -> np.ndarray:
    """The parts (lanes, rows, ..) of every pack side by side, and the packs one after another."""
    lanes, rows = sum(len(parts[0]) for parts in packs), sum(part.shape[1] for part in packs[0])
    whole, first = np.empty((lanes, rows, *packs[0][0].shape[2:])), 0
    for parts in packs:
        np.concatenate(parts, axis=1, out=whole[first : first + len(parts[0])])
        first += len(parts[0])
    return whole


def _bound(unknown: Unknown, value: float) -> float:
    return float(unknown.to_coordinate(max(value, 1e-300) if unknown.kind == "log" else value))


def _in_coordinates(unknown: Unknown) -> float:
    assert unknown.deviation is not None
    if unknown.kind == "linear":
        return unknown.deviation / unknown.scale
    assert unknown.centre is not None
    return unknown.deviation / unknown.centre
