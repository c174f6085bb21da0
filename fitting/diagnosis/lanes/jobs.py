"""What the program is run on to see a bench at a point, and what it differentiates by."""

from __future__ import annotations

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Job, Model, Prediction
from fitting.diagnosis.lanes.programs import COLUMNS
from fitting.diagnosis.lanes.wander import allowed


def job(model: Model, bench: Bench, point: Point, free: np.ndarray | None = None) -> Job:
    """The linearisation of a bench at a point by what each lane has of its own and, where free unknowns are
    given, by the level of friction and by these."""
    lanes = len(bench.lanes)
    chosen = np.full((lanes, COLUMNS), -1) if free is None else chosen_columns(free, model.level, lanes)
    deviation = allowed(bench.lanes, point.widths)
    return Job(
        point.attached, bench.lanes, deviation, point.each(model, bench), point.own, chosen, bench.whitener
    )


def predicted(model: Model, bench: Bench, point: Point) -> Prediction:
    """What a bench shows at a point."""
    return model.predict(point.attached, bench.lanes, point.each(model, bench), point.own)


def chosen_columns(free: np.ndarray, level: int, lanes: int) -> np.ndarray:
    """What the program differentiates by: the level of friction first, then the free unknowns."""
    return whole_columns(np.r_[level, free], lanes)


def whole_columns(numbers: np.ndarray, lanes: int) -> np.ndarray:
    """Unknowns to differentiate every lane by, with room up to what the program takes at once, or some times
    as much."""
    return np.tile(np.pad(numbers, (0, -len(numbers) % COLUMNS), constant_values=-1), (lanes, 1))
