"""Residuals of lanes and their derivatives, whatever number and length of lanes a program has room for."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.lanes import FEWEST, ROOMS, SAMPLES, Lanes, Misfit
from fitting.problem import Problem, pose
from fitting.segments import Segment, lay_out
from fitting.settings import Settings
from jaxstick.hypothesis import Hypothesis, effects_at_null
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import TRUTH, dataset, own_run

LONGEST = ROOMS[1] + 40
SUBSTEPS = 6
SHORT = ROOMS[0]


@pytest.fixture(scope="module")
def problem() -> Problem:
    run = own_run(SineDrive(1.5, 10.325e-3), samples=LONGEST + 1, file="run-0.csv")
    return pose(dataset(run), Settings(workers=2))


@pytest.fixture(scope="module")
def misfit(problem: Problem) -> Misfit:
    return Misfit(problem.hypothesis, problem.unknowns, workers=2)


@pytest.fixture(scope="module")
def truth(problem: Problem) -> np.ndarray:
    """The true constants as coordinates."""
    return true_coordinates(problem)


def true_coordinates(problem: Problem) -> np.ndarray:
    members = problem.unknowns.members
    return np.array([float(unknown.to_coordinate(TRUTH[unknown.name])) for unknown in members])


def laid(problem: Problem, *spans: tuple[int, int]) -> Lanes:
    segments = [Segment(0, first, last) for first, last in spans]
    return lay_out(problem.chosen, segments, problem.dataset.rig, problem.scale.force, SUBSTEPS)


def each(lanes: Lanes, coordinates: np.ndarray) -> np.ndarray:
    return np.tile(coordinates, (len(lanes), 1))


def test_a_lane_moves_alike_in_programs_with_room_for_more(problem, misfit, truth):
    """Short of a room, in it to the last sample, one beyond, and in the next."""
    whole = laid(problem, (0, LONGEST))
    start = np.asarray(whole.start)
    far = misfit.predict(whole, each(whole, truth), start)
    np.testing.assert_allclose(far[0], whole.displacement, rtol=0, atol=0.02 * np.ptp(far[0]))
    for samples in (SHORT - 3, SHORT, SHORT + 1, ROOMS[1]):
        short = laid(problem, (0, samples))
        for near, long in zip(misfit.predict(short, each(short, truth), start), far, strict=True):
            assert near.shape == (1, samples)
            np.testing.assert_allclose(near, long[:, :samples], rtol=0, atol=1e-9 * np.ptp(long))


def test_the_cost_is_that_of_what_is_predicted(problem, misfit, truth):
    lanes = laid(problem, (0, SHORT), (40, 40 + SHORT))
    starts = np.asarray(lanes.start) + 0.5 * np.asarray(lanes.start_deviation)
    displacement, friction = misfit.predict(lanes, each(lanes, truth), starts)
    expected = (
        np.sum((np.asarray(lanes.displacement_weight) * (displacement - lanes.displacement)) ** 2, axis=1)
        + np.sum((np.asarray(lanes.friction_weight) * (friction - lanes.friction)) ** 2, axis=1)
        + 3 * 0.5**2
    )
    np.testing.assert_allclose(misfit.linearise(lanes, each(lanes, truth), starts).cost, expected, rtol=1e-9)


def test_the_gradient_is_that_of_the_cost(problem, misfit, truth):
    """Against central differences of half the cost, by every constant and every start."""
    lanes = laid(problem, (20, 20 + SHORT))
    starts = np.asarray(lanes.start)
    off = truth + 0.02
    gradient = misfit.linearise(lanes, each(lanes, off), starts).gradient[0]
    steps = np.diag([*np.full(len(truth), 1e-5), *(1e-4 * np.asarray(lanes.start_deviation)[0])])
    point = np.concatenate([off, starts[0]])
    many = lanes.take(np.zeros(2 * len(point), int))
    moved = np.concatenate([point + steps, point - steps])
    cost = misfit.linearise(many, moved[:, : len(truth)], moved[:, len(truth) :]).cost
    ahead, behind = np.split(cost, 2)
    np.testing.assert_allclose((ahead - behind) / (4 * np.diag(steps)), gradient, rtol=1e-4)


def test_lanes_know_how_the_base_moves_at_their_samples(problem):
    lanes = laid(problem, (0, SHORT), (200, 200 + SHORT))
    time = np.asarray(lanes.start_time)[:, None] + np.asarray(lanes.interval)[:, None] * np.arange(SHORT)
    exact = SineDrive(1.5, 10.325e-3).at(time - time[0, 0] + 0.5)
    place, rate = lanes.base_motion()
    np.testing.assert_allclose(place, exact.y, rtol=0, atol=1e-4 * 10.325e-3)
    np.testing.assert_allclose(rate, exact.y_rate, rtol=0, atol=1e-3 * np.max(np.abs(exact.y_rate)))


def test_a_lane_remembers_where_the_mass_has_been():
    """A spring that relaxes, picked up in the middle of a record: told that the mass had kept still before,
    lanes end up elsewhere."""
    relaxing = dataclasses.replace(
        effects_at_null(("spring_relaxation",))["spring_relaxation"], stiffness=600.0, time=0.7
    )
    effects = {"spring_relaxation": relaxing}
    run = own_run(SineDrive(1.5, 10.325e-3), samples=1000, effects=effects, file="run-0.csv")
    problem = pose(dataset(run), Settings(workers=2))
    misfit = Misfit(Hypothesis(problem.hypothesis.nominal, effects), problem.unknowns, workers=2)
    known = true_coordinates(problem)
    lanes = laid(problem, *((first, first + SHORT) for first in range(600, 1000 - SHORT, 23)))
    track = lanes.before.track
    assert track is not None
    still = np.broadcast_to(np.asarray(lanes.start)[:, :1], np.shape(track.displacement))
    before = lanes.before._replace(track=track._replace(displacement=still))
    forgetful = dataclasses.replace(lanes, before=before)

    def error(lanes: Lanes) -> float:
        displacement, _ = misfit.predict(lanes, each(lanes, known), np.asarray(lanes.start))
        return float(np.sqrt(np.mean((displacement - lanes.displacement) ** 2)))

    assert error(lanes) < 0.05 * error(forgetful)


def test_many_lanes_give_what_each_gives_alone(problem, misfit, truth):
    """More than go through a program together."""
    pack = max(FEWEST, SAMPLES // SHORT)
    firsts = np.arange(pack + 3) % (LONGEST - SHORT)
    lanes = laid(problem, *((int(first), int(first) + SHORT) for first in firsts))
    found = misfit.follow(lanes, each(lanes, truth), np.asarray(lanes.start))
    for number in (0, 7, pack, pack + 2):
        one = lanes.take(np.array([number]))
        alone = misfit.follow(one, each(one, truth), np.asarray(one.start))
        for whole, part in ((found.linear.gradient, alone.linear.gradient), (found.end, alone.end)):
            np.testing.assert_allclose(whole[number], part[0], rtol=1e-9, atol=1e-9 * np.abs(whole).max())


def test_blocks_share_the_score(problem, misfit, truth):
    lanes = laid(problem, (0, 99), (50, 149))
    off, starts = truth + 0.02, np.asarray(lanes.start)
    p = len(truth)
    whole = misfit.scores(lanes, off, starts, 1)
    parts = misfit.scores(lanes, off, starts, 3)
    for one, three in zip(whole, parts, strict=True):
        assert len(three) == 3 * len(lanes) and np.all(np.any(three.reshape(len(three), -1) != 0, axis=1))
        summed = three.reshape(len(lanes), 3, *one.shape[1:]).sum(axis=1)
        np.testing.assert_allclose(summed, one, rtol=1e-9, atol=1e-9 * np.abs(one).max())
    assert whole[0].shape == (len(lanes), p) and whole[1].shape == (len(lanes), p, p)
