"""Lanes leaf by leaf give what they give as a tree."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np
import pytest

from fitting.diagnosis.lanes.model import PACK
from fitting.diagnosis.lanes.programs import COLUMNS, Pack, columns
from fitting.diagnosis.lanes.roomy import ROOMS, Roomy
from fitting.diagnosis.lanes.wander import OWN
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import laid_out
from tests.fitting.reference_data import TRUTH, dataset, own_run


@pytest.fixture(scope="module")
def laid():
    return laid_out(dataset(own_run(SineDrive(1.5, 10.325e-3), samples=600)))


def test_lanes_are_counted_on_from_the_first(laid):
    _, bench = laid
    roomy, count = Roomy(bench.lanes), len(bench.lanes)
    index = np.array([1, count, count + 1])
    deviation = np.arange(3.0 * OWN).reshape(3, OWN)
    whole = bench.lanes.filled(ROOMS[0]).take(index % count)
    wanted = jax.tree.leaves(dataclasses.replace(whole, start_deviation=deviation))
    for mine, theirs in zip(roomy.taken(index, deviation), wanted, strict=True):
        assert np.array_equal(mine, theirs)


def test_a_program_called_with_leaves_gives_what_it_gives_for_trees(laid):
    model, bench = laid
    roomy, index = Roomy(bench.lanes), np.arange(PACK)
    hypothesis, chart, own = model._attached(())
    coordinates = np.tile(model.origin(TRUTH)[own], (PACK, 1))
    deviation = np.ones((PACK, OWN))
    lanes = bench.lanes.filled(roomy.room).take(index % len(bench.lanes))
    lanes = dataclasses.replace(lanes, start_deviation=deviation)
    chosen = np.tile(np.where(np.arange(COLUMNS) < 2, np.arange(COLUMNS), -1), (PACK, 1))
    points = coordinates, np.zeros((PACK, OWN)), chosen
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        tree = columns(hypothesis, chart, Pack(lanes, bench.lanes.pace(), *points))
        call, constant = roomy.program(columns, (), hypothesis, chart, points)
        leaves = call(*constant, *roomy.taken(index, deviation), *roomy.pace, *points)
    for mine, theirs in zip(leaves, tree, strict=True):
        assert np.array_equal(mine, theirs) and np.any(np.asarray(mine) != 0)
