"""Records that scatter from cycle to cycle are weighed by what does not repeat itself."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.signal import lfilter

from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.wander import OWN
from fitting.diagnosis.noise.scatter import Scatter
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out
from tests.fitting.reference_data import NOISE, TRUTH, dataset, noisy, own_run

TIMES = 12.0
FREQUENCY, PERIOD = 0.9, 0.2175


@pytest.fixture(scope="module")
def unsteady():
    """A run whose friction force scatters in slip, by so many times its noise and slowly; its displacement
    does not. Under the true constants, but for a bias in the friction force that every cycle repeats."""
    assert NOISE.friction is not None
    random = np.random.default_rng(6)
    run = noisy(own_run(SineDrive(FREQUENCY, 10.325e-3), samples=3000), random)
    slow = np.asarray(lfilter([np.sqrt(1 - 0.9**2)], [1.0, -0.9], random.standard_normal(len(run.time))))
    assert run.friction is not None
    slips = np.abs(np.gradient(run.displacement, run.time)) > 0.02
    bias = 20 * NOISE.friction * np.sin(2 * np.pi * FREQUENCY * run.time)
    friction = run.friction + TIMES * NOISE.friction * slow * slips + bias
    model, bench = laid_out(dataset(dataclasses.replace(run, friction=friction)))
    point = from_the_truth(model, bench, (), model.origin(TRUTH)).point
    return model, bench, point, Scatter.of(model, bench, point, PERIOD)


def test_scatter_is_found_where_it_is(unsteady):
    """In the friction force in slip; a bias that repeats itself is none. Rarely at rest for long, the mass
    is taken to scatter there as it does in all."""
    scatter = unsteady[3]
    assert scatter.variances["slip"][1] == pytest.approx(1 + TIMES**2, rel=0.35)
    assert max(scatter.variances[event][1] for event in ("breakaway", "arrest")) < 10
    assert all(displacement < 2 for displacement, _ in scatter.variances.values())
    assert scatter.most()[1] == pytest.approx(TIMES, rel=0.25) and scatter.most()[0] < 1.5


def test_evened_residuals_change_from_cycle_to_cycle_by_one(unsteady):
    model, bench, point, scatter = unsteady
    even = scatter.evened(model, bench, point)
    assert even.scatters and not bench.scatters
    assert np.array_equal(even.share, bench.share) and np.array_equal(even.dof(), bench.dof())
    again = Scatter.of(model, even, point, PERIOD)
    assert again.variances["slip"] == pytest.approx((1.0, 1.0), abs=0.15)
    assert max(max(pair) for pair in again.variances.values()) < 1.3
    (columns,) = model.columns([job(model, even, point)])
    (before,) = model.columns([job(model, bench, point)])
    assert np.all(np.abs(columns.residual[:, :-OWN]) <= np.abs(before.residual[:, :-OWN]) + 1e-9)


def test_records_that_only_carry_noise_stay_as_they_are(unsteady):
    model = unsteady[0]
    run = noisy(own_run(SineDrive(FREQUENCY, 10.325e-3), samples=3000), np.random.default_rng(7))
    _, bench = laid_out(dataset(run))
    point = from_the_truth(model, bench, (), model.origin(TRUTH)).point
    scatter = Scatter.of(model, bench, point, PERIOD)
    assert all(variance < 2 for pair in scatter.variances.values() for variance in pair)
