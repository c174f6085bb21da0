"""What every run has of its own beside what all runs share: the normal equations, and a hum whose phase is
another in every run."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.centring import centred
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.layout import GAUGE, LEVELLED, Layout, owners, strengths_of, with_strengths
from fitting.diagnosis.lanes.model import LEVEL_TOLERANCE, Model
from fitting.diagnosis.lanes.programs import COLUMNS
from fitting.diagnosis.lanes.wander import OWN, START
from fitting.diagnosis.refits.refit import refit
from fitting.diagnosis.which.contest import contest
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.screen import screen
from fitting.diagnosis.which.starts import Approach
from fitting.diagnosis.words import of_every_run
from fitting.progress import Silent
from jaxstick.effects.mains_hum import MainsHum
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out, noisy_runs
from tests.fitting.reference_data import NOISE, TRUTH, dataset

HUM = "mains_hum"
PHASES = {0.9: (0.3, 0.1), 2.1: (-0.15, 0.275)}
"""Cosine and sine [N] in the run of each frequency [Hz]."""
assert NOISE.friction is not None
ERROR = 3 * 2 * NOISE.friction * math.sqrt(2 / 600)
"""Three standard errors of an amplitude, twice as many where the frequency is free as well."""


class Hummed(NamedTuple):
    model: Model
    bench: Bench
    nominal: Point
    found: Explanation


@pytest.fixture(scope="module")
def hummed() -> Hummed:
    """Two runs with hum at 50 Hz, and the refit of it that the screening leads to."""
    runs = noisy_runs({f: {HUM: MainsHum(*hum)} for f, hum in PHASES.items()}, 5)
    model, bench = laid_out(dataset(*runs))
    nominal = from_the_truth(model, bench, model.sharing.together((HUM,)), model.origin(TRUTH))
    seen = screen(model, bench, nominal, own_group=True)
    promise = next(promise for promise in seen.promises if promise.key == HUM)
    approach = Approach((1.0,), np.inf, False, False, False)
    (found,) = contest(model, bench, nominal, [promise], 1, Silent(), approach)
    return Hummed(model, bench, nominal.point, found)


def test_hum_of_another_phase_in_every_run_is_found(hummed: Hummed):
    model, found = hummed.model, hummed.found.refit
    slots = model.slots(model.index(f"{HUM}.cosine", f"{HUM}.sine"))
    scale = [model.members[number].scale for number in model.by_run[slots]]
    assert found.point.by_run[:, slots] * scale == pytest.approx(np.array([*PHASES.values()]), abs=ERROR)
    assert model.values(found.point.coordinates, [f"{HUM}.frequency"]) == pytest.approx(
        {f"{HUM}.frequency": 50.0}, abs=0.1
    )
    assert found.misfit == pytest.approx(1.0, abs=0.1)


def test_what_is_reported_of_it_is_the_first_run(hummed: Hummed):
    model, point = hummed.model, hummed.found.refit.point
    values = model.values(point.coordinates, [f"{HUM}.cosine", f"{HUM}.sine"])
    assert tuple(values.values()) == pytest.approx(PHASES[0.9], abs=ERROR)


def test_that_it_is_so_is_said(hummed: Hummed):
    (sentence,) = of_every_run(hummed.model, "run-0.9.csv", ["force_gain", HUM])
    assert sentence.startswith("Every run has cosine and sine of mains_hum of its own: given is what run-0.9")
    (sentence,) = of_every_run(hummed.model, "run-0.9.csv", ["force_highpass"])
    assert "before and held of force_highpass" in sentence, "a strength, and a shape"


def test_a_point_without_hum_has_none_in_any_run(hummed: Hummed):
    model, point = hummed.model, hummed.found.refit.point
    bare = point.without(model, [HUM])
    hum = model.slots(model.index(f"{HUM}.cosine", f"{HUM}.sine"))
    assert np.abs(point.by_run[:, hum]).min() > 0
    assert not bare.by_run[:, 1:].any()
    assert np.array_equal(bare.by_run[:, 0], point.by_run[:, 0])
    own = model.of(HUM)
    assert np.array_equal(bare.coordinates[own], model.origin({})[own])


def test_a_strength_of_every_run_counts_once_for_each(hummed: Hummed):
    cosine, sine = hummed.model.index(f"{HUM}.cosine", f"{HUM}.sine")
    assert owners(hummed.model, hummed.bench, HUM) == [(cosine, 0), (cosine, 1), (sine, 0), (sine, 1)]
    assert owners(hummed.model, hummed.bench, "force_gain")[0][1] is None


def test_strengths_are_set_as_they_are_read(hummed: Hummed):
    """Among the coordinates stands the first run's."""
    model, bench = hummed.model, hummed.bench
    wanted = np.array([0.1, 0.2, 0.3, 0.4])
    point = with_strengths(model, bench, hummed.nominal, HUM, wanted)
    np.testing.assert_array_equal(strengths_of(model, bench, point, HUM), wanted)
    np.testing.assert_array_equal(point.coordinates[model.index(f"{HUM}.cosine", f"{HUM}.sine")], [0.1, 0.3])
    assert not hummed.nominal.by_run[:, 1:].any()


def test_more_unknowns_than_the_program_takes_at_once_have_the_derivatives_of_each(hummed: Hummed):
    model, bench, point = hummed.model, hummed.bench, hummed.nominal
    free = np.concatenate([model.nuisances(), model.of(HUM), model.of("force_gain")])
    assert COLUMNS < 1 + len(free) < 2 * COLUMNS
    (whole,) = model.columns([job(model, bench, point, free)])
    few = np.split(free, [4, 11])
    parts = model.columns([job(model, bench, point, own) for own in few])
    each = [part.jacobian[:, :, 1 : 1 + len(own)] for part, own in zip(parts, few, strict=True)]
    np.testing.assert_array_equal(whole.jacobian[:, :, 1 : 1 + len(free)], np.concatenate(each, axis=2))
    for part in parts:
        np.testing.assert_array_equal(whole.jacobian[:, :, 0], part.jacobian[:, :, 0])
        np.testing.assert_array_equal(whole.jacobian[:, :, -OWN:], part.jacobian[:, :, -OWN:])
        np.testing.assert_array_equal(whole.residual, part.residual)


def test_the_rig_is_fitted_beside_effects_however_many_shapes_these_have(hummed: Hummed):
    """A model that lacked them had bent it."""
    model, bench, found = hummed.model, hummed.bench, hummed.found.refit
    free = np.concatenate([model.nuisances(), model.of(HUM), model.of("force_offset")])
    assert 1 + len(free) > COLUMNS
    bent = found.point.coordinates.copy()
    bent[model.index("rig.stiffness")] += math.log(1.006)
    keys = model.sharing.together((HUM, "force_offset"))
    point = dataclasses.replace(found.point, keys=keys, coordinates=bent)
    held, fitted = refit(model, bench, [point, point], [free[~np.isin(free, model.of_rig())], free])
    assert held.misfit > 1.1 * found.misfit
    assert fitted.misfit < 1.01 * found.misfit
    ((error,), (known,)) = (
        one.point.coordinates[model.index("rig.stiffness")] - model.origin({})[model.index("rig.stiffness")]
        for one in (fitted, found)
    )
    assert abs(error - known) < 0.001


def test_normal_equations_are_those_of_the_whole_problem(hummed: Hummed):
    """Lanes with a matrix each; put into one large matrix, row by row where their columns belong, they give
    the same equations."""
    model, bench = hummed.model, hummed.bench
    layout = Layout.of(model, bench, model.index("C", f"{HUM}.cosine", "D"))
    random = np.random.default_rng(1)
    lanes = len(bench.run)
    jacobian, residual = random.standard_normal((lanes, 7, 4)), random.standard_normal((lanes, 7))
    size = 2 + 2 * bench.runs
    whole = np.zeros((lanes, 7, size))
    for lane, run in enumerate(bench.run):
        shared, level, cosine = [0, 1], 2 + run, 2 + bench.runs + run
        whole[lane][:, [level, shared[0], cosine, shared[1]]] = jacobian[lane]
    flat = whole.reshape(-1, size)
    gradient = np.einsum("lrc,lr->lc", jacobian, residual)
    g, h = layout.summed(bench.run, gradient, jacobian.transpose(0, 2, 1) @ jacobian)
    np.testing.assert_allclose(g, flat.T @ residual.ravel(), atol=1e-12)
    np.testing.assert_allclose(h, flat.T @ flat, atol=1e-12)
    assert layout.of_free.tolist() == [0, 2 + bench.runs, 1]


def test_values_go_in_as_they_come_out(hummed: Hummed):
    model, bench = hummed.model, hummed.bench
    layout = Layout.of(model, bench, model.index("C", f"{HUM}.sine"))
    values = np.linspace(-0.2, 0.3, 1 + 2 * bench.runs)
    moved = layout.moved(model, hummed.nominal, values)
    np.testing.assert_array_equal(layout.values(moved), values)
    (sine,) = model.index(f"{HUM}.sine")
    assert moved.coordinates[sine] == values[1 + bench.runs]


@pytest.mark.parametrize("held", [True, False], ids=["friction is fitted", "friction stays"])
def test_the_prior_is_that_of_every_run(hummed: Hummed, held: bool):
    """Its gradient against central differences; the mean level of the runs is held where constants follow."""
    model, bench = hummed.model, hummed.bench
    free = model.index(*(LEVELLED if held else ()), "rig.mass", f"{HUM}.sine")
    layout = Layout.of(model, bench, free)
    shared = len(layout.shared)
    assert layout.fits_friction(model) is held
    values = np.concatenate([model.origin({})[layout.shared] + 0.003, [0.02, -0.01, 2.0, -3.0]])

    def prior(at: np.ndarray):
        return layout.prior(model, layout.moved(model, hummed.nominal, at))

    here = prior(values)
    for place in range(len(values)):
        step = np.zeros(len(values))
        step[place] = 1e-6
        slope = (prior(values + step).cost - prior(values - step).cost) / 4e-6
        assert here.gradient[place] == pytest.approx(slope, rel=1e-5, abs=1e-5)
    assert here.curvature[shared, shared] == pytest.approx(LEVEL_TOLERANCE**-2 + held * 0.25 * GAUGE**-2)
    lone = Layout.of(model, bench.take(np.flatnonzero(bench.run == 1)), free)
    alone = lone.prior(model, hummed.nominal)
    assert alone.curvature[shared, shared] == pytest.approx(LEVEL_TOLERANCE**-2)


def test_levels_of_lanes_go_to_their_runs_and_to_the_constants(hummed: Hummed):
    """The friction of every lane stays as it is: A, C and D times the levels of run and lane."""
    model, bench = hummed.model, hummed.bench
    random = np.random.default_rng(2)
    own, by_run = hummed.nominal.own.copy(), hummed.nominal.by_run.copy()
    own[:, START] = 0.05 + 0.02 * random.standard_normal(len(own))
    own[bench.run == 1, START] += 0.1
    by_run[:, 0] = 0.01, -0.02
    point = dataclasses.replace(hummed.nominal, own=own, by_run=by_run)
    better = centred(model, bench, point)
    assert better.own[:, START].max() < 0.1
    for run in (0, 1):
        assert better.own[bench.run == run, START].mean() == pytest.approx(0, abs=1e-15)
    assert better.by_run[:, 0].mean() == pytest.approx(0, abs=1e-15)

    def friction(at: Point) -> np.ndarray:
        constants = np.array([*model.values(at.coordinates, ("A", "C", "D")).values()])
        return constants * np.exp(at.by_run[bench.run, 0] + at.own[:, START])[:, None]

    np.testing.assert_allclose(friction(better), friction(point), rtol=1e-12)
    far = dataclasses.replace(point, own=own + np.array([0, 0, 0, 50.0, 0]))
    assert centred(model, bench, far) is far
