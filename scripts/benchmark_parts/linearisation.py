"""What the diagnosis spends its time on: a lane linearised with effects attached at null."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.laying import lay_whole
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.programs import COLUMNS
from fitting.diagnosis.lanes.wander import LEAST, OWN, START
from fitting.problem import pose
from fitting.settings import Settings
from jaxstick.record import load_dataset
from scripts.benchmark_parts.clock import fastest

RECORDS = Path(__file__).parents[2] / "data" / "rig1987"
SUBSTEPS = 16


class Linearised(NamedTuple):
    """The effects attached, none for the nominal model; the processor's time for the states and the Jacobian
    of a lane by what it has of its own, the constants and the strengths of these effects [s]; and how long it
    takes until the program is there, traced and compiled, next to nothing where it is there already [s]."""

    effects: tuple[str, ...]
    seconds: float
    compiled: float


def linearised(repeats: int, groups: int | None = None) -> list[Linearised]:
    """Times on one core: the nominal model, two effects as a refit has them, every group of effects that
    shares a program, or so many of them, and the whole shelf unless only so many groups are asked for."""
    model, bench, point = _laid_out()
    first, second, *_ = model.sharing.groups
    two = model.sharing.fitted((first[0], second[0]))
    attached = [(), two, *model.sharing.groups[:groups], *([model.sharing.whole] if groups is None else [])]
    candidates = {"+".join(keys): _linearisation(model, bench, point, keys) for keys in attached}
    begun = {name: _duration(candidate) for name, candidate in candidates.items()}
    times = fastest(candidates, repeats)
    names = ["+".join(keys) for keys in attached]
    return [
        Linearised(keys, times[name].processor / len(bench.lanes), max(begun[name] - times[name].wall, 0.0))
        for keys, name in zip(attached, names, strict=True)
    ]


def _duration(function: Callable[[], object]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def _laid_out() -> tuple[Model, Bench, Point]:
    """The model of the records, their lanes, and the assumed constants as a point."""
    problem = pose(load_dataset(RECORDS), Settings(workers=1))
    bench, model = lay_whole(problem, SUBSTEPS), Model(problem, 1)
    assumed = problem.dataset.assumed
    origin = model.origin({name: getattr(assumed, name) for name in model.constants})
    own, widths = np.asarray(bench.lanes.start), np.full(OWN - START, LEAST)
    return model, bench, Point((), origin, model.alike(bench.runs), own, widths)


def _linearisation(model: Model, bench: Bench, point: Point, keys: tuple[str, ...]) -> Callable[[], object]:
    strengths = [model.index(*model.shelf.strengths[key]) for key in keys]
    free = np.concatenate([model.index(*model.constants), *strengths])
    at = dataclasses.replace(point, keys=keys)
    asked = job(model, bench, at, free[: COLUMNS - 1])
    return lambda: model.columns([asked])
