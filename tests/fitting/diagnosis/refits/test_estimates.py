"""Intervals of the parameters of effects, and where they are open."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.estimates import _effects
from fitting.problem import pose
from fitting.settings import Settings
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import dataset, own_run

QUANTILE = 2.0
TIME, CURVATURE = 2e-3, 0.02


@pytest.mark.parametrize("known", [0.2, 0.45, 0.55])
def test_a_shape_known_to_within_itself_may_be_nothing(known: float):
    """Its logarithm is all but unbounded below then, however far its interval is from the search's bound; the
    strength beside it is told as ever."""
    run = own_run(SineDrive(1.5, 10e-3), samples=200)
    model = Model(pose(dataset(run), Settings()), 1)
    free = model.of("force_lowpass")
    coordinates = model.origin({})
    for place, value in zip(free.tolist(), (TIME, CURVATURE, 0.3), strict=True):
        coordinates[place] = model.members[place].to_coordinate(value)
    fit: Any = SimpleNamespace(free=free, point=SimpleNamespace(coordinates=coordinates))
    spread = np.array([0.05 * coordinates[free[0]], known, 0.1])
    time, curvature, _ = _effects(model, fit, ("force_lowpass",), spread, QUANTILE)["force_lowpass"]
    assert (time.low, time.high) == pytest.approx((0.9 * TIME, 1.1 * TIME))
    assert curvature.high == pytest.approx(CURVATURE * np.exp(QUANTILE * known))
    if QUANTILE * known < 1:
        assert curvature.low == pytest.approx(CURVATURE * np.exp(-QUANTILE * known))
    else:
        assert curvature.low is None
