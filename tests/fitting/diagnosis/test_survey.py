"""The survey: what explains the records as well as what was found first."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.contest import Explanation
from fitting.diagnosis.ground import Ground, ground
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import refit
from fitting.diagnosis.release import released
from fitting.diagnosis.screen import screen
from fitting.diagnosis.survey import second_look
from fitting.problem import pose
from fitting.progress import Silent
from fitting.settings import Settings
from jaxstick.effects.displacement_gain import DisplacementGain
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import WRONG, dataset, noisy, own_run

KEY, MATE = "stiffness_error", "displacement_gain"


@pytest.fixture(scope="module")
def enlarged() -> tuple[Model, Ground]:
    """Two noisy runs whose displacement is read 6 % too large, and their ground."""
    random = np.random.default_rng(8)
    runs = [
        noisy(
            own_run(
                SineDrive(f, 10.325e-3),
                effects={MATE: DisplacementGain(0.06)},
                samples=600,
                file=f"run-{f}.csv",
            ),
            random,
        )
        for f in (0.9, 2.1)
    ]
    settings = Settings(workers=2)
    problem = pose(dataset(*runs, assumed=WRONG), settings)
    model = Model(problem, settings.workers)
    return model, ground(problem, model, settings, Silent())


def test_an_effect_with_the_same_trace_is_found_where_the_other_stands(enlarged):
    """Springs and mass that are off do what a gain does; in their place the gain leaves no more than they.
    How large it is depends on mass and springs within their tolerance."""
    model, base = enlarged
    (nominal,) = refit(model, base.bench, [base.point], [model.nuisances()])
    promise = next(p for p in screen(model, base.bench, nominal, shapes=[]).promises if p.key == KEY)
    point = dataclasses.replace(nominal.point, keys=model.together((KEY,)))
    (other,) = refit(model, base.bench, [point], [np.concatenate([nominal.free, model.of(KEY)])])
    first = Explanation((KEY,), promise, released(model, base.bench, other))
    assert nominal.misfit > 100 and first.refit.misfit < 1.2
    found = {e.keys: e for e in second_look(model, base.bench, [first], KEY, 0, [], Silent())}
    assert (MATE,) in found and (KEY,) not in found
    gain = found[MATE,].refit
    assert gain.misfit < 1.2
    value = model.values(gain.point.coordinates, [f"{MATE}.gain"])[f"{MATE}.gain"]
    assert value == pytest.approx(0.06, abs=0.02)
