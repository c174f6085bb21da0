"""The coordinates in which a solver sees free parameters: there and back, bounds, slopes, priors."""

from __future__ import annotations

import math

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.unknowns import Unknown, Unknowns
from jaxstick.hypothesis import Hypothesis
from jaxstick.nominal import nominal
from jaxstick.parameter import find
from jaxstick.parts.drive import SineDrive
from tests.jaxstick.rig1987_runs import RIG, constants

UNKNOWNS = Unknowns(
    (
        Unknown("A", "N", 0.0, 21.0, "linear", 7.0),
        Unknown("B", "s/m", 0.5, 2e4, "log"),
        Unknown("mass", "kg", 0.8, 7.2, "log", 1.0, 2.4, 0.05),
        Unknown("damping", "N s/m", -3.0, 9.0, "linear", 3.0, 4.5, 0.9),
    )
)
SHARES = st.lists(st.floats(0.001, 0.999), min_size=len(UNKNOWNS), max_size=len(UNKNOWNS)).map(np.array)


def inside(share: np.ndarray) -> np.ndarray:
    return UNKNOWNS.lower + share * (UNKNOWNS.upper - UNKNOWNS.lower)


def slope_of(function, at: float, step: float = 1e-6) -> float:
    return (function(at + step) - function(at - step)) / (2 * step)


@given(SHARES)
def test_coordinates_and_values_invert_each_other(share):
    point = inside(share)
    values = UNKNOWNS.values(point)
    np.testing.assert_allclose(UNKNOWNS.coordinates(values), point, rtol=1e-12, atol=1e-12)
    for unknown in UNKNOWNS.members:
        assert unknown.lower < values[unknown.name] < unknown.upper


def test_coordinates_are_the_logarithm_or_the_value_over_its_scale():
    point = UNKNOWNS.coordinates({"A": 3.5, "B": 100.0, "mass": 2.4, "damping": -1.5})
    np.testing.assert_allclose(point, [0.5, math.log(100.0), math.log(2.4), -0.5], rtol=1e-15)
    assert UNKNOWNS.names == ("A", "B", "mass", "damping")
    assert UNKNOWNS.index("mass") == 2


def test_values_beyond_a_bound_are_moved_onto_it():
    low = UNKNOWNS.coordinates({"A": -1.0, "B": 0.0, "mass": 0.1, "damping": -5.0})
    high = UNKNOWNS.coordinates({"A": 99.0, "B": 1e9, "mass": 99.0, "damping": 99.0})
    np.testing.assert_allclose(low, UNKNOWNS.lower, rtol=1e-15)
    np.testing.assert_allclose(high, UNKNOWNS.upper, rtol=1e-15)
    assert np.all(np.isfinite(UNKNOWNS.to_unbounded(low)) & np.isfinite(UNKNOWNS.to_unbounded(high)))


@given(SHARES)
def test_stretched_coordinates_come_back_with_their_slope(share):
    point = inside(share)
    stretched = UNKNOWNS.to_unbounded(point)
    back, slope = UNKNOWNS.from_unbounded(stretched)
    np.testing.assert_allclose(back, point, rtol=1e-9, atol=1e-9)
    for i in range(len(UNKNOWNS)):

        def moved(value: float, i: int = i) -> float:
            there = stretched.copy()
            there[i] = value
            return float(UNKNOWNS.from_unbounded(there)[0][i])

        assert slope[i] == pytest.approx(slope_of(moved, stretched[i]), rel=1e-5)


@given(st.lists(st.floats(-50.0, 50.0), min_size=len(UNKNOWNS), max_size=len(UNKNOWNS)).map(np.array))
def test_no_stretched_coordinate_leaves_the_bounds(stretched):
    point, _ = UNKNOWNS.from_unbounded(stretched)
    room = 1e-12 * (UNKNOWNS.upper - UNKNOWNS.lower)
    assert np.all((point >= UNKNOWNS.lower - room) & (point <= UNKNOWNS.upper + room))


@given(SHARES)
def test_the_prior_has_the_gradient_and_curvature_of_its_cost(share):
    point = inside(share)
    cost, gradient, curvature = UNKNOWNS.prior(point)
    for i in range(len(UNKNOWNS)):

        def moved(value: float, what: int, i: int = i) -> float:
            there = point.copy()
            there[i] = value
            answer = UNKNOWNS.prior(there)[what]
            return float(answer if what == 0 else answer[i])  # pyright: ignore[reportArgumentType,reportIndexIssue]

        assert 2 * gradient[i] == pytest.approx(
            slope_of(lambda value: moved(value, 0), point[i]), rel=1e-4, abs=1e-5 * (1 + cost)
        )
        assert curvature[i] == pytest.approx(slope_of(lambda value: moved(value, 1), point[i]), rel=1e-6)


def test_the_prior_costs_one_a_standard_deviation_from_its_centre():
    centre = UNKNOWNS.coordinates({"A": 1.0, "B": 9.0, "mass": 2.4, "damping": 4.5})
    assert UNKNOWNS.prior(centre)[0] == pytest.approx(0.0, abs=1e-20)
    aside = UNKNOWNS.coordinates({"A": 5.0, "B": 99.0, "mass": 2.4, "damping": 5.4})
    assert UNKNOWNS.prior(aside)[0] == pytest.approx(1.0)
    heavier = UNKNOWNS.coordinates({"A": 1.0, "B": 9.0, "mass": 2.4 * math.exp(0.05 / 2.4), "damping": 4.5})
    assert UNKNOWNS.prior(heavier)[0] == pytest.approx(1.0)


def test_a_chart_puts_the_values_into_a_hypothesis():
    hypothesis = Hypothesis(nominal(RIG, constants(0.86), SineDrive(1.5, 0.01)))
    values = {"A": 3.5, "B": 120.0, "mass": 2.2, "damping": 4.0}
    new = UNKNOWNS.chart().insert(hypothesis, jnp.asarray(UNKNOWNS.coordinates(values)))
    for name, value in values.items():
        assert float(find(new, name).of(new)) == pytest.approx(value, rel=1e-12)
    assert find(new, "C").of(new) == find(hypothesis, "C").of(hypothesis)
