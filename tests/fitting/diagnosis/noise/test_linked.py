"""What friction that scatters does to the displacement is known from the force."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.model import Job
from fitting.diagnosis.noise.linked import response, whitener
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out
from tests.fitting.reference_data import TRUTH, dataset, noisy, own_run

MASS, STIFFNESS, DAMPING, INTERVAL = 2.38, 1986.0, 4.5, 2e-3
PERIOD = 0.2175


def test_the_response_is_that_of_the_free_rig():
    """Against an integrator with an error control, under a force that varies smoothly."""

    def force(t):
        return 0.3 + np.sin(40 * t)

    def rate(t, z):
        return [z[1], (force(t) - DAMPING * z[1] - STIFFNESS * z[0]) / MASS]

    t = INTERVAL * np.arange(80)
    exact = solve_ivp(rate, (0, t[-1]), [0, 0], t_eval=t, rtol=1e-10, atol=1e-14).y[0]
    found = response(INTERVAL, MASS, STIFFNESS, DAMPING, len(t)) @ force(t)
    assert found == pytest.approx(exact, abs=1e-3 * np.abs(exact).max())


@pytest.fixture(scope="module")
def slips():
    """A run under the true model, its lanes, and the whitener where friction may scatter by a newton."""
    run = noisy(own_run(SineDrive(0.9, 10.325e-3), samples=1200), np.random.default_rng(3))
    model, bench = laid_out(dataset(run))
    point = from_the_truth(model, bench, (), model.origin(TRUTH)).point
    scatter = np.full(bench.share.shape[:2], 1.0)
    return model, bench, point, whitener(model, bench, point, scatter, PERIOD)


def test_what_a_force_does_to_the_displacement_is_taken_out_of_it(slips):
    """The force has the same in it; what the displacement has by itself stays."""
    model, bench, point, matrices = slips
    samples = bench.lanes.displacement.shape[1]
    rig = model.at(point.coordinates, ()).nominal.rig
    moves = response(
        float(bench.lanes.interval[0]), float(rig.mass), float(rig.stiffness), float(rig.damping), samples
    )
    weights = bench.lanes.weights()[0]
    counts = (bench.share[0] > 0).all(1)
    force = np.sin(0.1 * np.arange(samples)) * counts
    alone = np.concatenate([weights[:, 0] * (moves @ force), 0 * force])
    both = alone + np.concatenate([0 * force, weights[:, 1] * force])
    left = (matrices[0] @ both)[:samples]
    assert np.abs(left).max() < 0.02 * np.abs(alone).max()
    assert np.abs((matrices[0] @ alone)[:samples]).max() > 20 * np.abs(left).max()


def test_a_level_of_friction_leaves_no_trace_in_the_displacement(slips):
    """Mechanics cannot hide in friction that wanders: the derivative by the level of a lane is gone
    from the rows of the displacement, that by a stiffness is not."""
    model, bench, point, matrices = slips
    samples = bench.lanes.displacement.shape[1]
    plain = job(model, bench, point)
    own = model.columns([plain])[0].jacobian[:, :samples, -2]
    freed = model.columns([plain._replace(whitener=matrices)])[0].jacobian[:, :samples, -2]
    assert np.sqrt(np.mean(freed**2)) < 0.1 * np.sqrt(np.mean(own**2))


def test_what_is_mixed_is_mixed_for_several_searches_alike(slips):
    model, bench, point, matrices = slips
    one = job(model, dataclasses.replace(bench, whitener=matrices), point)
    twice = np.tile(np.arange(len(bench.lanes)), 2)
    two = Job(
        one.keys,
        one.lanes,
        one.deviation[twice],
        one.coordinates[twice],
        one.own[twice],
        one.chosen[twice],
        matrices,
    )
    (single,), (double,) = model.columns([one]), model.columns([two])
    count = len(bench.lanes)
    for half in (slice(count), slice(count, None)):
        assert double.residual[half] == pytest.approx(single.residual, rel=1e-9, abs=1e-9)
        assert double.jacobian[half] == pytest.approx(single.jacobian, rel=1e-9, abs=1e-9)


def test_samples_that_do_not_count_are_not_mixed_in(slips):
    model, bench, point, _ = slips
    share = bench.share.copy()
    share[:, ::7, 1] = 0.0
    weights = np.where(share > 0, bench.lanes.weights(), 0.0)
    lanes = dataclasses.replace(bench.lanes, friction_weight=weights[:, :, 1])
    gaps = dataclasses.replace(bench, share=share, lanes=lanes)
    matrices = whitener(model, gaps, point, np.full(share.shape[:2], 1.0), PERIOD)
    assert matrices is not None
    lost = np.flatnonzero(share[0].T.ravel() == 0)
    assert not matrices[0][lost].any() and not matrices[0][:, lost].any()


def test_lanes_without_friction_stay_as_they_are(slips):
    model, bench, point, _ = slips
    share = bench.share * [1.0, 0.0]
    lanes = dataclasses.replace(bench.lanes, friction_weight=np.zeros(share.shape[:2]))
    mute = dataclasses.replace(bench, share=share, lanes=lanes)
    assert whitener(model, mute, point, np.ones(share.shape[:2]), PERIOD) is None
