"""Numbers that are reported lie at the optimum, on steps that are fine enough, without what is not there."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.confidence import deviations, step_to_optimum
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.reported import FINER, TOLERATED, reported
from jaxstick.effects.drive_backlash import DriveBacklash
from tests.fitting.diagnosis.grounded import (
    SUBSTEPS,
    fitted_from_the_truth,
    from_the_truth,
    laid_out,
    noisy_runs,
)
from tests.fitting.reference_data import TRUTH, dataset

GAP = 4e-4


@pytest.fixture(scope="module")
def fitted() -> tuple[Model, Bench, Refit]:
    """A record of the 1987 rig, its lanes fitted from the true constants on."""
    return fitted_from_the_truth(600)


def away(model: Model, bench: Bench, fit: Refit) -> float:
    """How many standard deviations the farthest of its parameters lies from the optimum."""
    return float(np.max(np.abs(step_to_optimum(model, bench, fit) / deviations(model, bench, fit).spread)))


def moved(model: Model, bench: Bench, fit: Refit, times: float) -> Refit:
    """The refit with its parameters so many standard deviations farther."""
    coordinates = fit.point.coordinates.copy()
    coordinates[fit.free] += times * deviations(model, bench, fit).spread * [1, -1, 1, -1, 1]
    return dataclasses.replace(fit, point=dataclasses.replace(fit.point, coordinates=coordinates))


def test_it_lies_at_the_optimum(fitted):
    """Where a search for a verdict would rest, parameters may lie a good part of a standard deviation off."""
    model, bench, fit = fitted
    off = moved(model, bench, fit, 0.3)
    (rests,) = refit(model, bench, [off.point], [off.free], enough=1.0)
    assert away(model, bench, rests) > 0.2
    fine, found = reported(model, bench, rests)
    assert away(model, fine, found) < 0.05


def test_steps_are_as_fine_as_parameters_ask_for(fitted):
    model, bench, fit = fitted
    fine, _ = reported(model, bench, fit)
    assert fine.lanes.substeps == SUBSTEPS
    coarse = bench.paced(1)
    less_coarse, found = reported(model, coarse, fit)
    assert less_coarse.lanes.substeps == FINER
    (there,) = refit(model, bench, [fit.point], [fit.free], enough=1e-7)
    (here,) = refit(model, coarse, [fit.point], [fit.free], enough=1e-7)
    spread = deviations(model, bench, there).spread
    errors = [
        np.max(np.abs((one.point.coordinates - there.point.coordinates)[fit.free]) / spread)
        for one in (here, found)
    ]
    assert errors[0] > TOLERATED and errors[1] < errors[0] / 4


def test_a_part_of_an_effect_that_is_not_there_is_none():
    """Searched by its logarithm it would end at a hundredth, which the gap and the springs make good."""
    model, bench = loose(DriveBacklash(GAP))
    keys = model.sharing.together(("drive_backlash",))
    gap, floating = model.index("drive_backlash.gap", "drive_backlash.floating")
    constants = from_the_truth(model, bench, keys, begun(model, GAP, 0.01))
    free = np.concatenate([constants.free, model.of("drive_backlash")])
    (fit,) = refit(model, bench, [constants.point], [free])
    fine, found = reported(model, bench, fit)
    assert floating in fit.free and floating not in found.free
    assert model.members[floating].to_value(found.point.coordinates[floating]) == 0
    assert found.misfit <= fit.misfit
    place = found.free.tolist().index(gap)
    seen = deviations(model, fine, found)
    error = found.point.coordinates[gap] - model.members[gap].to_coordinate(GAP)
    assert abs(error) < seen.quantile * seen.spread[place]


def test_a_part_of_an_effect_that_is_there_stays():
    model, bench = loose(DriveBacklash(GAP, 0.5))
    keys = model.sharing.together(("drive_backlash",))
    (floating,) = model.index("drive_backlash.floating")
    constants = from_the_truth(model, bench, keys, begun(model, GAP, 0.5))
    free = np.concatenate([constants.free, model.of("drive_backlash")])
    (fit,) = refit(model, bench, [constants.point], [free])
    _, found = reported(model, bench, fit)
    assert floating in found.free
    assert model.members[floating].to_value(found.point.coordinates[floating]) == pytest.approx(0.5, rel=0.2)


def loose(play: DriveBacklash) -> tuple[Model, Bench]:
    """Two runs of the 1987 rig whose drive has play, and their model."""
    acting = {"drive_backlash": play}
    return laid_out(dataset(*noisy_runs({0.9: acting, 1.5: acting}, 2)))


def begun(model: Model, gap: float, floating: float) -> np.ndarray:
    """Coordinates of the true constants with such play."""
    values = {"drive_backlash.gap": gap, "drive_backlash.floating": floating}
    coordinates = model.origin(TRUTH)
    for name, value in values.items():
        (place,) = model.index(name)
        coordinates[place] = model.members[place].to_coordinate(value)
    return coordinates


def test_what_may_have_either_sign_is_no_part_of_an_effect(fitted):
    """It has a zero of its own to be fitted to."""
    model, _, _ = fitted
    assert len(model.parts_of_it(model.of("drive_backlash"))) == 1
    assert len(model.parts_of_it(model.of("mains_hum"))) == 0
