"""The refit whose numbers are reported: at its optimum, on steps as fine as its parameters ask for, and
without parts of effects that are not there.

A verdict needs none of that. But a search that ends where next to nothing of chi-square is to be gained may
end a standard deviation off, steps that leave residuals alone move a parameter that few samples tell by
several, and a part of an effect that is searched by its logarithm never becomes nothing.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.confidence import deviations, step_to_optimum
from fitting.diagnosis.refits.refit import Refit, refit

CLOSELY = 0.02
"""A search ends where it gains less of chi-square than this."""
TOLERATED = 0.2
"""So many standard deviations may halved steps move a parameter; where they move one by more, there are"""
FINER = 4
"""times as many."""
PART_OF_IT = 4.0
"""A part that makes less difference than this to chi-square is not there."""


def reported(model: Model, bench: Bench, fit: Refit) -> tuple[Bench, Refit]:
    """What a refit comes to, and the bench with the steps that it asks for."""
    fit = _closely(model, bench, fit)
    for number in model.parts_of_it(fit.free).tolist():
        without = _closely(model, bench, _without(model, fit, number))
        if (without.misfit - fit.misfit) * float(bench.dof().sum()) < PART_OF_IT:
            fit = without
    if not _moves(model, bench, fit) > TOLERATED:
        return bench, fit
    finer = bench.paced(FINER * bench.lanes.substeps)
    return finer, _closely(model, finer, fit)


def _closely(model: Model, bench: Bench, fit: Refit) -> Refit:
    enough = CLOSELY / float(bench.dof().sum())
    (found,) = refit(model, bench, [fit.point], [fit.free], enough=enough)
    return found


def _without(model: Model, fit: Refit, number: int) -> Refit:
    """Where the refit without this part of an effect begins."""
    coordinates = fit.point.coordinates.copy()
    coordinates[number] = -math.inf
    point = dataclasses.replace(fit.point, coordinates=coordinates)
    return fit.begun(point, fit.free[fit.free != number])


def _moves(model: Model, bench: Bench, fit: Refit) -> float:
    """By how many standard deviations steps half as long move what moves most."""
    here, there = (step_to_optimum(model, one, fit) for one in (bench, bench.paced(2 * bench.lanes.substeps)))
    return float(np.max(np.abs(there - here) / deviations(model, bench, fit).spread, initial=0.0))
