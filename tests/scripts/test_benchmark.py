"""The benchmark: its opponents solve the same equations, and the quick run gives its figures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from scripts import benchmark
from scripts.benchmark_parts import c_lanes, contest, growth, lanes, numba_lanes, ours, scipy_events

STEPS = 20


@pytest.fixture(scope="module")
def few() -> lanes.Checked:
    return lanes.checked(5)


def test_numba_and_we_step_alike(few: lanes.Checked) -> None:
    """The same scheme twice: to 1e-9 of the stroke, and within the contest's error of the reference."""
    by_us = ours.simulate(few.lanes, STEPS, 1)
    stroke = np.ptp(few.exact)
    assert np.abs(numba_lanes.simulate(few.lanes, STEPS) - by_us).max() < 1e-9 * stroke
    assert few.error(by_us) < 3 * lanes.ERROR


def test_c_and_we_step_alike(few: lanes.Checked, tmp_path: Path) -> None:
    """Also where the lanes fill no block, and on two threads."""
    in_c = c_lanes.simulator(tmp_path, block=16)
    if in_c is None:
        pytest.skip("no C compiler")
    by_us = ours.simulate(few.lanes, STEPS, 1)
    for workers in (1, 2):
        assert np.abs(in_c(few.lanes, STEPS, workers) - by_us).max() < 1e-9 * np.ptp(few.exact)


@pytest.mark.parametrize("method", ["LSODA", "RK45"])
def test_scipy_meets_the_events_of_the_reference(few: lanes.Checked, method: str) -> None:
    assert few.error(scipy_events.simulate(few.lanes, method, 1e-7)) < lanes.ERROR


def test_the_jacobian_is_that_of_the_displacement(few: lanes.Checked) -> None:
    """By C, the third of its constants, against a central difference."""
    jacobian = ours.jacobian(few.lanes, STEPS, 1)
    assert jacobian.shape == (5, lanes.SAMPLES, 5)
    shift = 1e-6
    up, down = (ours.simulate(few.lanes._replace(C=few.lanes.C + side * shift), STEPS, 1) for side in (1, -1))
    difference = (up - down) / (2 * shift)
    assert np.abs(jacobian[:, :, 2] - difference).max() < 1e-3 * np.abs(difference).max()


def test_the_loosest_setting_that_meets_the_error_is_taken(few: lanes.Checked) -> None:
    def simulate(size: float) -> np.ndarray:
        return few.exact + size * np.ptp(few.exact, axis=1, keepdims=True)

    setting, error = contest.loosest((1.0, 1e-5, 1e-6), simulate, few)
    assert setting == 1e-5
    assert error == pytest.approx(1e-5)


@pytest.mark.usefixtures("user_session")
def test_quick_run_prints_every_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    """As JSON, of still fewer lanes than --quick takes; times are positive and errors met."""
    tiny = contest.Size(lanes=16, tsit5_lanes=2, checked=2, scipy_lanes=1, repeats=1)
    monkeypatch.setattr(benchmark, "QUICK", tiny)
    monkeypatch.setattr(benchmark, "COUNTS", (1, 16, 24))
    monkeypatch.setattr(contest, "STEPS", (20, 28, 40))
    result = CliRunner().invoke(benchmark.main, ["--quick", "--json"], catch_exceptions=False)
    assert result.exit_code == 0
    figures = json.loads(result.stdout)
    solvers = {row["solver"]: row for row in figures["solvers"]}
    assert {"jaxstick", "numba loop", "diffrax Tsit5, vmap", "scipy LSODA, events"} <= set(solvers)
    assert solvers["jaxstick"]["ratio_one_core"] == 1.0
    for row in figures["solvers"]:
        assert row["error"] <= lanes.ERROR, row
        assert row["one_core"] > 0
    assert [row["lanes"] for row in figures["growth"]] == [1, 16, 24]
    assert all(row["jacobian_in_simulations"] > 0 for row in figures["growth"])
    alone, *attached = figures["linearised"]
    assert alone["effects"] == [] and alone["nominal"] == 1.0 and alone["seconds"] > 0
    two, group = (row["effects"] for row in attached)
    assert len(two) == 2 < len(group) and all(row["nominal"] > 0 for row in attached)
    assert all(row["compiled"] >= 0 for row in figures["linearised"])
    assert len(benchmark.tables(figures)) == 3


def test_no_accelerator_no_figure() -> None:
    assert growth.accelerator(8, 4, 1) is None
