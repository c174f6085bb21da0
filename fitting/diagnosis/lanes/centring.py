"""Where levels of friction belong: the mean of a run's lanes to the run, the mean of all runs to the
constants."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.layout import LEVELLED
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import START


def centred(model: Model, bench: Bench, point: Point) -> Point:
    """The same motion with levels of friction where they belong: the mean of a run's lanes is the run's, the
    mean of all runs in A, C and D, which levels multiply. A search that may damp every lane's steps would
    leave them for long where they do not.
    """
    levelled = in_runs(bench, point)
    by_run, coordinates = levelled.by_run.copy(), point.coordinates.copy()
    runs = np.unique(bench.run)
    common = by_run[runs, 0].mean()
    by_run[runs, 0] -= common
    levelled_by = model.index(*LEVELLED)
    for number in levelled_by:
        member = model.members[number]
        coordinates[number] = member.to_coordinate(member.to_value(coordinates[number]) * math.exp(common))
    inside = ((coordinates >= model.lower) & (coordinates <= model.upper))[levelled_by]
    if not inside.all() or np.abs(by_run[:, 0]).max() > model.upper[model.level]:
        return point
    return dataclasses.replace(levelled, coordinates=coordinates, by_run=by_run)


def in_runs(bench: Bench, point: Point) -> Point:
    """The same motion with what the levels of a run's lanes have in common in the run's own."""
    own, by_run = point.own.copy(), point.by_run.copy()
    for run in np.unique(bench.run):
        mean = own[bench.run == run, START].mean()
        own[bench.run == run, START] -= mean
        by_run[run, 0] += mean
    return dataclasses.replace(point, by_run=by_run, own=own)
