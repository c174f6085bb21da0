"""Sweeps from Python: the grid, the columns, their derivatives, and that lanes do not see each other."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from jaxstick.errors import UserError
from jaxstick.record import AssumedConstants
from jaxstick.sweep import Points, compute, grid, lane_records, sweep
from tests.jaxstick.rig1987_runs import RIG, STOPS, constants

CONSTANTS = constants(0.86)
AMPLITUDE = 10.325e-3


@pytest.mark.parametrize("dynamic_ratio", [0.85, 0.86, 0.90])
def test_the_stops_of_the_paper(dynamic_ratio: float) -> None:
    found = sweep(RIG, constants(dynamic_ratio), ratios=list(STOPS), amplitudes=AMPLITUDE)
    assert dict(zip(STOPS, found["stops"], strict=True)) == STOPS


def test_the_frequency_ratio_runs_fastest_then_the_amplitude() -> None:
    points = grid(RIG, CONSTANTS, ratios=[0.5, 0.6], amplitudes=[0.01, 0.02], C=[5.0, 6.0, 7.0])
    assert len(points) == 12
    assert points.values["drive.frequency"][:3] == pytest.approx(
        RIG.natural_frequency * np.array([0.5, 0.6, 0.5])
    )
    assert points.values["drive.base_amplitude"][:5].tolist() == [0.01, 0.01, 0.02, 0.02, 0.01]
    assert points.values["friction.C"].tolist() == [5.0] * 4 + [6.0] * 4 + [7.0] * 4


def test_level_and_friction_ratio_make_A_and_C() -> None:
    points = grid(RIG, CONSTANTS, ratios=0.5, amplitudes=0.01, friction_ratio=[0.8, 1.0], level=10.0)
    assert points.values["friction.A"] == pytest.approx([2.0, 0.0])
    assert points.values["friction.C"] == pytest.approx([8.0, 10.0])
    points = grid(RIG, CONSTANTS, ratios=0.5, amplitudes=0.01, level=[5.0])
    assert points.values["friction.C"] == pytest.approx([0.86 * 5.0])
    points = grid(RIG, AssumedConstants(k1=1e5), ratios=0.5, amplitudes=0.01, friction_ratio=0.8, level=10.0)
    assert points.values["friction.A"] == pytest.approx([2.0])


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"ratios": [0.5, 0.0]}, "ratios must be finite and positive; 0 is not"),
        ({"ratios": []}, "ratios has no values"),
        ({"ratios": ["a"]}, "ratios must be numbers"),
        ({"amplitudes": np.nan}, "amplitudes must be finite and positive"),
        ({"A": -1.0}, "A must be finite and not negative"),
        ({"A": 1.0, "level": 2.0}, "level and A cannot both be given"),
        ({"friction_ratio": 1.1}, "must not exceed 1"),
        ({"contact": "sticky"}, "no contact called 'sticky'"),
    ],
)
def test_what_makes_no_sense_is_refused(given: dict[str, Any], sentence: str) -> None:
    usual: dict[str, Any] = {"ratios": [0.5], "amplitudes": [0.01]}
    with pytest.raises(UserError, match=sentence):
        grid(RIG, CONSTANTS, **(usual | given))


def test_what_cannot_be_swept_is_refused() -> None:
    with pytest.raises(UserError, match="no natural frequency"):
        grid(replace(RIG, stiffness=0.0), CONSTANTS, ratios=0.5, amplitudes=0.01)
    with pytest.raises(UserError, match="needs A and C"):
        grid(RIG, AssumedConstants(k1=1e5), ratios=0.5, amplitudes=0.01, level=10.0)
    with pytest.raises(UserError, match="C and k1"):
        grid(RIG, AssumedConstants(), ratios=0.5, amplitudes=0.01)
    with pytest.raises(UserError, match="not 'mass'"):
        compute(grid(RIG, CONSTANTS, ratios=0.5, amplitudes=0.01), derivatives=["mass"])


def test_a_lane_is_the_same_alone_and_among_others() -> None:
    """To the last digit, those that are not periodic included; the points survive a pickle."""
    points = grid(RIG, CONSTANTS, ratios=np.linspace(0.045, 1.0, 45), amplitudes=AMPLITUDE)
    together = compute(points)
    again: Points = pickle.loads(pickle.dumps(points))
    for some in (slice(0, 1), slice(1, 12), np.array([44, 3, 20])):
        apart = compute(again[some])
        for name, column in apart.items():
            np.testing.assert_array_equal(column, together[name][some], err_msg=name)


def test_chunks_are_joined_in_order() -> None:
    given = {"ratios": np.linspace(0.3, 0.9, 7), "amplitudes": AMPLITUDE}
    told: list[tuple[int, int]] = []
    found = sweep(RIG, CONSTANTS, **given, lanes_at_once=3, progress=lambda *at: told.append(at))
    assert told == [(3, 7), (6, 7), (7, 7)]
    assert found["frequency_ratio"] == pytest.approx(given["ratios"], rel=1e-12)
    assert len(found) == 7
    with pytest.raises(ValueError, match="read-only"):
        found["stops"][0] = 1


def test_records_are_what_sweep_json_asks_for() -> None:
    columns = compute(
        grid(RIG, CONSTANTS, ratios=[0.326, 0.0496], amplitudes=AMPLITUDE), derivatives=["C", "A"]
    )
    columns["period"][1] = 0
    columns["multiplier"][1] = np.nan
    first, second = json.loads(json.dumps(lane_records(columns), allow_nan=False))
    assert first["frequency_ratio"] == pytest.approx(0.326)
    assert first["frequency_hz"] == pytest.approx(0.326 * RIG.natural_frequency)
    assert first["base_amplitude_m"] == AMPLITUDE
    assert first["amplitude_ratio"] == pytest.approx(first["amplitude_m"] / AMPLITUDE)
    assert (first["stops"], first["period"]) == (2, 1)
    assert isinstance(first["stops"], int)
    assert 0 < first["stick_fraction"] < 1
    assert first["residual"] < 1e-9
    assert len(first["harmonics"]) == 9
    assert first["energy_per_cycle_j"] == pytest.approx(first["friction_work_j"] + first["viscous_work_j"])
    assert first["transmissibility"] == pytest.approx(first["harmonics"][0] / AMPLITUDE)
    assert first["derivatives"]["C"]["amplitude_m"] < 0
    assert len(first["derivatives"]["C"]["harmonics"]) == 9
    assert second["period"] is None
    assert second["multiplier"] is None


def test_derivatives_are_those_of_the_outcomes() -> None:
    """Against plain differences of two sweeps; that the derivatives are exact is tested on the states."""
    given = {"ratios": [0.35, 0.5, 0.7, 0.95], "amplitudes": AMPLITUDE}
    found = sweep(RIG, CONSTANTS, **given, derivatives=["C", "A"])
    assert CONSTANTS.C is not None
    more, less = (sweep(RIG, CONSTANTS, **given, C=CONSTANTS.C + shift) for shift in (1e-3, -1e-3))
    for outcome in (
        *("amplitude_m", "amplitude_ratio", "transmissibility", "phase_rad", "energy_per_cycle_j"),
        *("friction_work_j", "viscous_work_j", "harmonics", "harmonic_phases"),
    ):
        slope = (more[outcome] - less[outcome]) / 2e-3
        exact = found[f"d_{outcome}_d_C"]
        if exact.ndim == 2:
            assert exact.shape == (4, 9)
            slope, exact = slope[:, :3:2], exact[:, :3:2]
        assert exact == pytest.approx(slope, rel=2e-3), outcome
    assert not np.allclose(found["d_amplitude_m_d_A"], found["d_amplitude_m_d_C"])
