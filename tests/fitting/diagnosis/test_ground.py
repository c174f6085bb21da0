"""The search for the nominal model's constants does not stop at a contact of another stiffness."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.ground import RESTARTS, other_stiffnesses
from fitting.diagnosis.refit import refit
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out
from tests.fitting.reference_data import TRUTH, dataset, noisy, own_run


@pytest.mark.parametrize("off", [0.1, 4.0])
def test_a_stiffness_that_is_far_off_is_mended(off):
    """The other constants are about right; from where it stands, least squares does not find it."""
    run = noisy(own_run(SineDrive(1.5, 10.325e-3), samples=600), np.random.default_rng(2))
    model, bench = laid_out(dataset(run))
    fit = from_the_truth(model, bench, (), model.origin(TRUTH))
    (place,) = model.index("k1")
    coordinates = fit.point.coordinates.copy()
    coordinates[place] = model.members[place].to_coordinate(off * TRUTH["k1"])
    astray = dataclasses.replace(fit.point, coordinates=coordinates)
    (stuck,) = refit(model, bench, [astray], [fit.free], wander=False)
    found = other_stiffnesses(model, bench, dataclasses.replace(fit, point=astray))
    values = [model.members[place].to_value(constants[place]) / TRUTH["k1"] for constants in found]
    assert len(found) == RESTARTS and stuck.misfit > 2 * fit.misfit
    assert min(abs(np.log(values))) < np.log(1.35)
