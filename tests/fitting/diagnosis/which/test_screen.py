"""What the screening promises is what a refit finds, as far as an effect is small."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.lanes.wander import START
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.scores import bounded
from fitting.diagnosis.which import screen as screening
from fitting.diagnosis.which.screen import Promise, screen
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import UNEVEN, Screened, from_the_truth, laid_out, screened
from tests.fitting.reference_data import TRUTH, dataset, noisy, own_run

DRY = 0.01
GAINS = "force_gain", "displacement_gain"


@pytest.fixture(scope="module")
def slight() -> Screened:
    """A screening where dry friction differs by one part in a hundred between the directions."""
    return screened(1.0, DRY)


@pytest.fixture(scope="module")
def found(slight: Screened) -> Refit:
    free = np.concatenate([slight.fit.free, slight.model.of(UNEVEN)])
    (with_effect,) = refit(slight.model, slight.bench, [slight.fit.point], [free], wander=False)
    return with_effect


def test_the_expected_change_is_the_strength(slight: Screened, found: Refit):
    promise = next(promise for promise in slight.seen.usual if promise.key == UNEVEN)
    (dry,) = slight.model.index(f"{UNEVEN}.dry")
    scale = slight.model.members[dry].scale
    assert promise.change[0] * scale == pytest.approx(DRY, rel=0.1)
    assert found.point.coordinates[dry] * scale == pytest.approx(DRY, rel=0.05)


def test_the_fall_of_chi_square_is_the_score(slight: Screened, found: Refit):
    promise = next(promise for promise in slight.seen.usual if promise.key == UNEVEN)
    assert (slight.fit.cost - found.cost).sum() == pytest.approx(promise.score, rel=0.1)


def test_constants_make_room_as_promised(slight: Screened, found: Refit):
    """Each constant ends where the linearised model says, to within a fifth of the way."""
    promise = next(promise for promise in slight.seen.usual if promise.key == UNEVEN)
    free = slight.fit.free
    way = found.point.coordinates[free] - slight.fit.point.coordinates[free]
    foretold = (promise.around + promise.room)[: len(free)]
    np.testing.assert_allclose(foretold, way, rtol=0.2, atol=1e-4)
    assert np.abs(promise.room).max() > 0.01


def test_what_lanes_have_of_their_own_makes_room_as_promised(slight: Screened, found: Refit):
    """Displacement, velocity and force at the beginnings of typical lanes, to within a fifth of the way."""
    promise = next(promise for promise in slight.seen.usual if promise.key == UNEVEN)
    way = (found.point.own - slight.fit.point.own)[:, :START]
    off = way - (promise.own_around + promise.own_room)[:, :START]
    assert np.all(np.median(np.abs(way), axis=0)[:2] > 0)
    assert np.all(np.median(np.abs(off), axis=0) <= np.median(np.abs(way), axis=0) / 5)


def test_a_shape_is_not_chosen_for_what_a_forbidden_sign_promises(
    slight: Screened, monkeypatch: pytest.MonkeyPatch
):
    """Another shape promises twice as much, with a sign that the strength may not have."""
    model, bench, fit, _ = slight
    key = "contact_damping"
    real = screening._promise

    def promised(table: Any, key: str, place: np.ndarray, shape: np.ndarray) -> Promise:
        made = real(table, key, place, shape)
        assert made.feasible == (bool(model.lower[model.of(key)[0]] < 0) or made.change[0] > 0)
        return dataclasses.replace(made, score=1.0 + len(shape), feasible=not len(shape))

    monkeypatch.setattr(screening, "_promise", promised)
    shape = fit.point.coordinates[model.index(*model.shelf.shapes[key])] + 0.5
    found = screen(model, bench, fit, own_group=True, shapes=[{key: shape}])
    (chosen,) = (promise for promise in found.promises if promise.key == key)
    assert not len(chosen.shape) and chosen.second is not None and len(chosen.second.shape)


def test_a_jump_of_the_force_does_not_outweigh_what_a_time_does_elsewhere():
    """One sample in the middle of a jump, of 4 lanes of 100; what is no time keeps its peaks."""
    model: Any = SimpleNamespace(members=[SimpleNamespace(unit=unit) for unit in ("s", "1", "s")])
    jacobian = np.random.default_rng(1).uniform(-1, 1, (4, 100, 3))
    jacobian[2, 50] = -900.0
    jacobian[:, :, 2] = 0.0
    seen = bounded(model, np.array([0, 1, 2]), jacobian)
    assert -4.0 <= seen[2, 50, 0] < -3.5 and seen[2, 50, 1] == -900.0
    changed = seen != jacobian
    assert changed.sum() == 1 and jacobian[2, 50, 0] == -900.0


def test_what_leaves_no_trace_in_these_records_cannot_be_seen():
    """A fault of the force sensor where no force was recorded."""
    exact = own_run(SineDrive(1.5, 10.325e-3), samples=600)
    whole = noisy(exact, np.random.default_rng(4))
    seen = {}
    for run in (whole, dataclasses.replace(whole, friction=None)):
        model, bench = laid_out(dataset(run))
        fit = from_the_truth(model, bench, model.sharing.together(GAINS), model.origin(TRUTH))
        usual = screen(model, bench, fit, own_group=True, shapes=[]).usual
        seen[run.friction is not None] = {promise.key: promise.can_be_seen for promise in usual}
    assert seen[True]["force_gain"] and not seen[False]["force_gain"]
    assert seen[True]["displacement_gain"] and seen[False]["displacement_gain"]


def test_only_what_is_wanted_is_screened(slight: Screened):
    """And what it promises does not depend on what else is screened."""
    seen = screen(slight.model, slight.bench, slight.fit, only=[UNEVEN], shapes=[])
    assert seen.keys == (UNEVEN,)
    (promise,) = seen.usual
    before = next(one for one in slight.seen.usual if one.key == UNEVEN)
    assert promise.score == pytest.approx(before.score)
