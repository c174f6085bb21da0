"""Segments joined into longer ones: which belong together, and gaps that close without losing the record."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from fitting.joining import LOOSENESS, chains, join
from fitting.newton import settle
from fitting.problem import pose
from fitting.segments import Segment, cut, lay_out, merged
from fitting.settings import Settings
from fitting.stage import stage, unit
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import TRUTH, dataset, own_run

DRIVE = SineDrive(0.9, 10.325e-3)
SETTINGS = Settings(resolution=200.0)


def test_merged_segments_are_made_of_whole_ones_and_cover_the_runs():
    parts = [Segment(0, 10 * i, 10 * i + 10) for i in range(11)] + [
        Segment(1, 7 * i, 7 * i + 7) for i in range(5)
    ]
    wholes = merged(merged(parts, 2), 2)
    assert [(s.run, s.first, s.last) for s in merged(parts, np.inf)] == [(0, 0, 110), (1, 0, 35)]
    assert {s.first for s in wholes} <= {s.first for s in parts}
    for run, end in ((0, 110), (1, 35)):
        mine = [s for s in wholes if s.run == run]
        assert mine[0].first == 0 and mine[-1].last == end
        assert all(one.last == other.first for one, other in itertools.pairwise(mine))
    links = chains(parts, wholes)
    assert [part for chain in links for part in chain] == list(range(len(parts)))
    assert [parts[chain[0]].first for chain in links] == [s.first for s in wholes]


@pytest.fixture(scope="module")
def posed():
    """A run of jaxstick's own without noise, its shortest segments, and starts that suit the truth."""
    problem = pose(dataset(own_run(DRIVE)), SETTINGS)
    parts = cut(problem.chosen, unit(problem))
    here = stage(problem, 1, parts, TRUTH["k1"], SETTINGS)
    lanes = lay_out(
        problem.chosen, parts, problem.dataset.rig, problem.scale.force, here.lanes.substeps, beyond=1
    )
    truth = problem.unknowns.coordinates(TRUTH)
    starts, _ = settle(here.misfit, lanes, truth, np.asarray(lanes.start))
    return problem, here, lanes, truth, starts


def gaps(here, lanes, links, found) -> np.ndarray:
    """By how much each lane of a chain misses the start of the next: displacement, velocity, force."""
    each = np.broadcast_to(found.coordinates, (len(lanes), len(found.coordinates)))
    end = here.misfit.follow(lanes, each, found.starts).end
    before = [lane for chain in links for lane in chain[:-1]]
    after = [lane for chain in links for lane in chain[1:]]
    return end[before] - found.starts[after]


def test_where_a_lane_arrives_is_where_the_next_sample_is(posed):
    problem, here, lanes, truth, starts = posed
    each = np.broadcast_to(truth, (len(lanes), len(truth)))
    followed = here.misfit.follow(lanes, each, starts)
    alone = here.misfit.linearise(lanes, each, starts)
    np.testing.assert_allclose(followed.linear.curvature, alone.curvature, rtol=1e-9)
    record = problem.chosen[0].run
    arrival = np.array([segment.last for segment in here.segments[:-1]])
    np.testing.assert_allclose(followed.end[:-1, 0], record.displacement[arrival], atol=2e-7)

    h = 1e-6
    for direction in (0, 4, len(truth)):
        moved, displaced = each.copy(), starts.copy()
        if direction < len(truth):
            moved[:, direction] += h
        else:
            displaced[:, direction - len(truth)] += h * 1e-3
        step = h if direction < len(truth) else h * 1e-3
        change = (here.misfit.follow(lanes, moved, displaced).end - followed.end)[:, 0] / step
        np.testing.assert_allclose(
            np.median(np.abs(change - followed.end_jacobian[:, 0, direction])), 0, atol=1e-4 * np.ptp(change)
        )


def test_the_gaps_close_and_the_constants_come_home(posed):
    _, here, lanes, truth, starts = posed
    random = np.random.default_rng(3)
    off = truth + 0.02 * random.standard_normal(len(truth)) * np.array([1, 1, 0.2, 0, 1])
    links = chains(here.segments, merged(here.segments, 16))
    scale = np.array([8e-6, 1e-3, 0.05])
    shaken = starts + scale * random.standard_normal(starts.shape)
    found = join(here.misfit, lanes, links, off, shaken)
    missed = np.abs(gaps(here, lanes, links, found)) / scale
    assert np.quantile(missed, 0.9) < 10 * LOOSENESS[-1]
    np.testing.assert_allclose(found.coordinates[[0, 1, 2, 4]], truth[[0, 1, 2, 4]], rtol=1e-3, atol=1e-3)


def test_without_links_every_lane_is_left_to_itself(posed):
    _, here, lanes, truth, starts = posed
    random = np.random.default_rng(3)
    shaken = starts + np.array([8e-6, 1e-3, 0.05]) * random.standard_normal(starts.shape)
    alone = join(here.misfit, lanes, [(lane,) for lane in range(len(lanes))], truth, shaken)
    _, cost = settle(here.misfit, lanes, truth, shaken)
    assert np.median(alone.cost) <= np.median(cost) * 1.01 + 1e-9
