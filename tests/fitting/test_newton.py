"""Least squares over lanes: the elimination of the starts, the solution, bounds, robustness, freed lanes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.lanes import Linearisation
from fitting.newton import OUTLIER, Robust, reduce, settle, solve, unstick
from fitting.problem import Problem, pose
from fitting.segments import cut, merged
from fitting.settings import Settings
from fitting.stage import Stage, stage, unit
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import TRUTH, dataset, own_run

P = 5


def linearisation(
    lanes: int = 4, p: int = P, residuals: int = 20
) -> tuple[Linearisation, np.ndarray, np.ndarray]:
    """A random linear problem: per lane residuals r and their derivative J in p unknowns and 3 starts."""
    random = np.random.default_rng(7)
    r = random.standard_normal((lanes, residuals))
    jacobian = random.standard_normal((lanes, residuals, p + 3)) * np.logspace(0, 2, p + 3)
    linear = Linearisation(
        np.einsum("lr,lr->l", r, r),
        np.einsum("lr,lrq->lq", r, jacobian),
        np.einsum("lrp,lrq->lpq", jacobian, jacobian),
    )
    return linear, r, jacobian


def test_the_reduced_equations_give_the_step_of_the_full_ones():
    linear, r, jacobian = linearisation()
    lanes, residuals, _ = jacobian.shape
    full = np.zeros((lanes * residuals, P + 3 * lanes))
    for lane in range(lanes):
        rows = slice(lane * residuals, (lane + 1) * residuals)
        full[rows, :P] = jacobian[lane, :, :P]
        full[rows, P + 3 * lane : P + 3 * lane + 3] = jacobian[lane, :, P:]
    expected = np.linalg.lstsq(full, -r.reshape(-1), rcond=None)[0]
    reduced = reduce(linear, P)
    step = -np.linalg.solve(reduced.curvature.sum(0), reduced.gradient.sum(0))
    np.testing.assert_allclose(step, expected[:P], rtol=1e-8)
    starts = reduced.start_step + reduced.start_response @ step
    np.testing.assert_allclose(starts.reshape(-1), expected[P:], rtol=1e-8)


def test_damping_adds_a_share_of_the_starts_own_curvature():
    linear, _, _ = linearisation()
    own = linear.curvature[:, P:, P:]
    damped = linear.curvature.copy()
    damped[:, P:, P:] = own + 0.5 * own * np.eye(3)
    got, expected = reduce(linear, P, 0.5), reduce(linear._replace(curvature=damped), P)
    np.testing.assert_allclose(got.start_step, expected.start_step, rtol=1e-12)
    np.testing.assert_allclose(got.curvature, expected.curvature, rtol=1e-9)


def test_a_lane_far_above_the_rest_counts_less_and_its_cost_grows_with_the_root():
    dof = np.full(5, 100)
    cost = np.array([90.0, 100.0, 100.0, 110.0, 1600.0])
    robust = Robust.around(cost, dof)
    assert robust.level == 1.0
    np.testing.assert_allclose(robust.weights(cost), [1, 1, 1, 1, 0.5])
    assert robust.total(cost) == pytest.approx(400 + 2 * np.sqrt(400 * 1600) - 400)
    for where in (300.0, 900.0):
        lane, h = Robust(np.array([100]), 1.0), 1e-4
        slope = (lane.total(np.array([where + h])) - lane.total(np.array([where - h]))) / (2 * h)
        assert slope == pytest.approx(lane.weights(np.array([where]))[0], rel=1e-6)
    assert OUTLIER == 4.0


@pytest.fixture(scope="module")
def posed() -> tuple[Problem, Stage]:
    """A run without noise that jaxstick made, cut into segments of two natural periods."""
    problem = pose(dataset(own_run(SineDrive(1.5, 10.325e-3))), Settings())
    segments = merged(cut(problem.chosen, unit(problem)), 4)
    return problem, stage(problem, 4, segments, TRUTH["k1"], Settings(resolution=200.0))


@pytest.fixture(scope="module")
def truth(posed) -> np.ndarray:
    return posed[0].unknowns.coordinates(TRUTH)


@pytest.fixture(scope="module")
def settled(posed, truth) -> tuple[np.ndarray, np.ndarray]:
    """Starts that suit the truth, and what each lane then costs."""
    here = posed[1]
    return settle(here.misfit, here.lanes, truth, np.asarray(here.lanes.start))


def wrong(problem: Problem) -> np.ndarray:
    off = {"A": 1.3, "B": 0.8, "C": 0.97, "D": 1.0, "k1": 1.2}
    return problem.unknowns.coordinates({name: TRUTH[name] * off[name] for name in TRUTH})


def test_data_without_noise_give_the_truth_back(posed):
    problem, here = posed
    (found,) = solve(here.misfit, here.lanes, wrong(problem)[None], np.asarray(here.lanes.start)[None])
    values = problem.unknowns.values(found.coordinates)
    assert found.converged
    assert found.linear.cost.sum() / here.lanes.counted().sum() < 0.05
    assert not found.at_bound[[0, 1, 2, 4]].any()
    for name, relative in {"A": 2e-2, "B": 4e-2, "C": 3e-3, "k1": 2e-2}.items():
        assert values[name] == pytest.approx(TRUTH[name], rel=relative), name
    assert list(found.history) == sorted(found.history, reverse=True)


def test_a_held_unknown_stays_where_it_is_and_the_others_move(posed):
    problem, here = posed
    fixed = np.array([name == "C" for name in problem.unknowns.names])
    point = wrong(problem)
    (found,) = solve(
        here.misfit, here.lanes, point[None], np.asarray(here.lanes.start)[None], fixed=fixed, iterations=8
    )
    assert found.coordinates[2] == point[2]
    assert np.all(found.coordinates[[0, 1, 4]] != point[[0, 1, 4]])
    (free,) = solve(here.misfit, here.lanes, point[None], np.asarray(here.lanes.start)[None], iterations=100)
    assert free.cost < found.cost


@pytest.mark.parametrize(("bound", "factor"), [("lower", 1.05), ("upper", 0.95)])
def test_a_bound_that_bars_the_truth_is_kept_and_reported(posed, truth, settled, bound, factor):
    problem, here = posed
    members = tuple(
        dataclasses.replace(u, **{bound: factor * TRUTH["C"]}) if u.name == "C" else u
        for u in problem.unknowns.members
    )
    unknowns = dataclasses.replace(problem.unknowns, members=members)
    bounded = dataclasses.replace(problem, unknowns=unknowns)
    misfit = stage(bounded, 4, here.segments, TRUTH["k1"], Settings(resolution=200.0)).misfit
    point = unknowns.coordinates(TRUTH)
    (found,) = solve(misfit, here.lanes, point[None], settled[0][None], iterations=10)
    values = unknowns.values(found.coordinates)
    assert values["C"] == pytest.approx(factor * TRUTH["C"], rel=1e-12)
    assert found.at_bound[2]
    assert np.all((found.coordinates >= unknowns.lower) & (found.coordinates <= unknowns.upper))


def test_a_spoilt_lane_is_weighed_down_and_does_not_move_the_answer(posed, truth, settled):
    _, here = posed
    random = np.random.default_rng(3)
    spoilt = np.array(here.lanes.friction) + 0.03 * random.standard_normal(here.lanes.friction.shape)
    clean = dataclasses.replace(here.lanes, friction=spoilt)
    spoilt = spoilt.copy()
    spoilt[1] += 3.0
    lanes = dataclasses.replace(here.lanes, friction=spoilt)
    (fair,) = solve(here.misfit, clean, truth[None], settled[0][None])
    (found,) = solve(here.misfit, lanes, truth[None], settled[0][None])
    plain = Robust(lanes.counted(), 1e9)
    (trusting,) = solve(here.misfit, lanes, truth[None], settled[0][None], robust=plain)
    assert found.weights[1] < 0.2 and np.all(np.delete(found.weights, 1) == 1.0)

    def away(solution) -> float:
        return abs(solution.coordinates[2] - fair.coordinates[2])

    assert away(found) < 0.5 * away(trusting)


def test_a_lane_that_began_on_the_wrong_side_is_freed(posed, truth, settled):
    _, here = posed
    random = np.random.default_rng(5)
    friction = np.array(here.lanes.friction) + 0.03 * random.standard_normal(here.lanes.friction.shape)
    lanes = dataclasses.replace(here.lanes, friction=friction)
    good, cost = settle(here.misfit, lanes, truth, settled[0])
    assert unstick(here.misfit, lanes, truth, good, cost) is None, "nothing is stuck yet"
    caught = good.copy()
    caught[0] += np.array([0.0, -40.0, 0.0]) * np.asarray(lanes.start_deviation)[0]
    at = here.misfit.linearise(lanes, np.broadcast_to(truth, (len(lanes), P)), caught).cost
    assert at[0] > 10 * cost[0]
    freed = unstick(here.misfit, lanes, truth, caught, at)
    assert freed is not None
    assert np.array_equal(freed[1:], caught[1:]), "lanes that fit are left alone"
    _, after = settle(here.misfit, lanes, truth, freed)
    np.testing.assert_allclose(after[0], cost[0], rtol=1e-2)
