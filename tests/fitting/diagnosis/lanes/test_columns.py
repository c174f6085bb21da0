"""Derivatives are mixed as residuals are, and only when they are asked for."""

from __future__ import annotations

import numpy as np
import pytest

from fitting.diagnosis.lanes import columns as module
from fitting.diagnosis.lanes.columns import Columns

LANES, HALF, EXTRA, EACH = 3, 4, 2, 5


@pytest.fixture
def plain() -> Columns:
    """Columns of three lanes, twice, two rows more than are mixed."""
    random = np.random.default_rng(1)
    rows = 2 * HALF + EXTRA
    return Columns(
        random.normal(size=(2 * LANES, rows)),
        random.normal(size=(2 * LANES, rows, EACH)),
        random.normal(size=(2 * LANES, HALF, 3)),
    )


@pytest.fixture
def whitener() -> np.ndarray:
    """Matrices that make no friction of a displacement."""
    made = np.random.default_rng(2).normal(size=(LANES, 2 * HALF, 2 * HALF))
    made[:, HALF:, :HALF] = 0.0
    return made


def test_residuals_and_derivatives_are_mixed_alike(plain, whitener):
    mixed = plain.whitened(whitener)
    for lane in range(2 * LANES):
        whole = np.eye(2 * HALF + EXTRA)
        whole[: 2 * HALF, : 2 * HALF] = whitener[lane % LANES]
        assert mixed.residual[lane] == pytest.approx(whole @ plain.residual[lane])
        assert mixed.jacobian[lane] == pytest.approx(whole @ plain.jacobian[lane])
        assert np.array_equal(mixed.states[lane], plain.states[lane])


def test_only_the_derivatives_that_there_are_need_be_mixed(plain, whitener):
    used = np.array([0, 3])
    some, every = plain.whitened(whitener, used).jacobian, plain.whitened(whitener).jacobian
    assert some[:, :, used] == pytest.approx(every[:, :, used])
    assert np.array_equal(some[:, :, 1], plain.jacobian[:, :, 1])


def test_derivatives_that_nobody_asks_for_are_not_mixed(plain, whitener, monkeypatch):
    mixed = plain.whitened(whitener)
    monkeypatch.setattr(module, "_mixed", None)
    half = mixed.part(slice(LANES, None))
    assert np.array_equal(half.residual, mixed.residual[LANES:])
    with pytest.raises(TypeError):
        _ = half.jacobian


def test_the_columns_of_some_times_are_mixed_as_those_of_all(plain, whitener):
    mixed = plain.whitened(whitener)
    half = mixed.part(slice(LANES, None))
    assert half.jacobian == pytest.approx(mixed.jacobian[LANES:])
    assert half.residual == pytest.approx(mixed.residual[LANES:])


def test_without_a_whitener_they_stay_as_they_are(plain):
    same = plain.whitened(None)
    assert same is plain and same.jacobian is plain.plain
