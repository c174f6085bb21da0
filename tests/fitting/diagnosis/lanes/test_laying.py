"""How records become lanes: corners count for less, for sensor and sampling decide them, samples that stand
out do not, and starts are not held to what a sensor reads."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.lanes.laying import NOISY_BEND, tempered
from fitting.diagnosis.refits.refit import refit
from fitting.problem import pose
from fitting.segments import Segment, lay_out
from fitting.settings import Settings
from jaxstick.effects.displacement_gain import DisplacementGain
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Noise
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out
from tests.fitting.reference_data import NOISE, TRUTH, WRONG, dataset, noisy, own_run

SAMPLES = 60


@pytest.fixture(scope="module")
def lanes():
    """One lane of a record, its displacement put to rest."""
    run = noisy(own_run(SineDrive(1.5, 10.325e-3), samples=SAMPLES), np.random.default_rng(0))
    problem = pose(dataset(run, assumed=WRONG), Settings(workers=1))
    whole = lay_out(problem.chosen, [Segment(0, 0, SAMPLES)], problem.dataset.rig, problem.scale.force, 1)
    still = np.zeros_like(np.asarray(whole.displacement))
    ones = np.ones_like(still)
    return dataclasses.replace(
        whole, displacement=still, friction=still, displacement_weight=ones, friction_weight=ones
    )


def weights(lanes, samples: np.ndarray) -> np.ndarray:
    given = dataclasses.replace(lanes, displacement=samples[None])
    return np.asarray(tempered(given).displacement_weight)[0]


def test_a_corner_counts_for_less(lanes):
    """A bend far above the noise, in units of it; away from it and below it all samples count fully."""
    corner = np.maximum(np.arange(SAMPLES) - 30.0, 0.0)
    sharp = weights(lanes, 100 * NOISY_BEND * corner)
    assert sharp[29:32].max() < 0.1
    assert np.all(sharp[[*range(28), *range(34, SAMPLES)]] == 1)
    assert np.all(weights(lanes, 0.9 * NOISY_BEND * corner) == 1)


def test_a_sample_that_stands_out_is_no_corner(lanes):
    spike = np.zeros(SAMPLES)
    spike[30] = 100 * NOISY_BEND
    assert np.all(weights(lanes, spike) == 1)


def test_samples_that_count_for_less_are_expected_to():
    """Residuals of noise alone come to the degrees of freedom, in a stick-slip record."""
    stated = dataset(noisy(own_run(SineDrive(1.5, 10.325e-3), samples=600), np.random.default_rng(1)))
    _, bench = laid_out(stated)
    weights = np.asarray(bench.lanes.displacement_weight), np.asarray(bench.lanes.friction_weight)
    assert NOISE.displacement is not None and NOISE.friction is not None
    plain = 1 / NOISE.displacement, 1 / NOISE.friction
    for place, (weight, whole) in enumerate(zip(weights, plain, strict=True)):
        noise = np.random.default_rng(2).standard_normal((200, *weight.shape)) / whole
        cost = np.mean((weight * noise) ** 2, axis=0)
        assert bench.share[:, :, place].sum() == pytest.approx(cost.sum(), rel=0.01)
    few = np.array([1, 3])
    assert np.all(bench.share <= 1) and np.mean(bench.share[:, :, 1] < 1) > 0.2
    assert np.all(bench.take(few).dof() == bench.dof()[few])


def test_starts_do_not_hold_a_gain_to_nothing():
    """A sensor of little noise reads 6 % too much: the gain is found as far as the rig's tolerance goes."""
    gain, noise = 0.06, Noise(displacement=1e-6, friction=0.03)
    exact = own_run(SineDrive(1.5, 10.325e-3), effects={"gain": DisplacementGain(gain)}, samples=1000)
    model, bench = laid_out(dataset(noisy(exact, np.random.default_rng(3), noise), noise=noise))
    keys, name = model.sharing.together(("displacement_gain",)), "displacement_gain.gain"
    begin = from_the_truth(model, bench, keys, model.origin(TRUTH))
    free = np.concatenate([model.nuisances(), model.of("displacement_gain")])
    (found,) = refit(model, bench, [begin.point], [free], wander=False)
    assert begin.misfit > 100 and found.misfit < 1.2
    assert model.values(found.point.coordinates, [name])[name] == pytest.approx(gain, abs=0.015)
