"""The search for the nominal model's constants stops neither at a contact of another stiffness, nor where
short segments led it astray."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.noise import ground as grounds
from fitting.diagnosis.noise.ground import RESTARTS, UNITS, other_stiffnesses
from fitting.diagnosis.refits.refit import refit
from fitting.settings import Settings
from fitting.stage import steps
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import from_the_truth, grounded_on, laid_out, noisy_runs
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


def test_without_a_force_channel_short_segments_do_not_decide_where_to_go_on(monkeypatch):
    """From a contact so soft that the mass never slips no refit comes back."""
    runs = [dataclasses.replace(run, friction=None) for run in noisy_runs({0.9: {}, 2.1: {}}, 3)]
    sift, sifted = grounds._best, []

    def astray(model, fits):
        """What was best on short segments, which are sifted twice, is as poor as can be."""
        sifted.append(len(fits))
        poor = np.clip(model.origin({**TRUTH, "k1": 300.0}), model.lower, model.upper)
        return [poor[model.index(*model.constants)]] if len(sifted) <= 2 else sift(model, fits)

    monkeypatch.setattr(grounds, "_best", astray)
    problem, model, found = grounded_on(runs)
    constants = model.index(*model.constants)
    (fit,) = refit(model, found.bench, [found.point], [constants], wander=False)
    assert fit.misfit < 1.5
    assert not found.bench.wanders and len(sifted) == 3
    stiffness = model.values(found.point.coordinates, ["k1"])["k1"]
    assert found.bench.lanes.substeps >= steps(problem, UNITS, stiffness / 2, Settings())


@pytest.mark.parametrize("far", [True, False])
def test_where_much_is_left_short_segments_do_not_decide_either(monkeypatch, far):
    """A strong effect that the model lacks may lead the search astray; here the search itself is poor."""
    sifted, sift, much = [], grounds._also_on_longer, grounds.ASTRAY

    def poor(model, *_):
        astray = np.clip(model.origin({**TRUTH, "k1": 0.05 * TRUTH["k1"]}), model.lower, model.upper)
        return [astray[model.index(*model.constants)]]

    def counted(model, bench, points):
        sifted.append(len(points))
        return sift(model, bench, points)

    monkeypatch.setattr(grounds, "sought", poor)
    monkeypatch.setattr(grounds, "_also_on_longer", counted)
    monkeypatch.setattr(grounds, "ASTRAY", much if far else np.inf)
    _, model, found = grounded_on(noisy_runs({0.9: {}, 2.1: {}}, 3))
    (fit,) = refit(model, found.bench, [found.point], [model.index(*model.constants)], wander=False)
    assert found.bench.wanders and sifted == ([len(found.begins)] if far else [])
    assert fit.misfit < 1.2 if far else fit.misfit > much
