"""Identified against assumed: numbers, amplitudes and stops."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from fitting.compare import OTHERS, compare
from fitting.save import fit_content
from fitting.saved import SavedFit, read_fit
from jaxstick.catalogue import catalogue
from jaxstick.hypothesis import effects_at_null
from jaxstick.nominal import nominal
from jaxstick.outcome import outcome
from jaxstick.output import to_json
from jaxstick.parameter import parameters
from jaxstick.parts.drive import SineDrive
from jaxstick.record import AssumedConstants, Noise, RigSheet, RunPlan
from jaxstick.simulate import simulate
from tests.fitting.tiny import ASSUMED, RIG, TRUE


@pytest.fixture(scope="module")
def saved(fitted, tiny, tmp_path_factory) -> SavedFit:
    path = tmp_path_factory.mktemp("compare") / "fit.json"
    path.write_text(to_json(fit_content(fitted, tiny)), encoding="utf-8")
    return read_fit(path)


@pytest.fixture(scope="module")
def comparison(saved):
    return compare(saved)


def sheet(*plans: RunPlan, assumed: AssumedConstants = ASSUMED) -> RigSheet:
    return RigSheet(
        path=Path("rig.toml"),
        name="rig",
        rig=RIG,
        assumed=assumed,
        noise=Noise(),
        runs=plans,
        notices=(),
        sha256="0",
    )


def test_every_run_with_both_sets_and_each_constant_alone(comparison, tiny):
    assert [run.file for run in comparison.runs] == [run.file for run in tiny.runs]
    for run in comparison.runs:
        assert set(run.exchanged) == {"A", "B", "C", "D", "k1"}
        assert run.assumed.cycles == run.identified.cycles == 4
        assert run.measured.cycles == 2
    assert comparison.notices == () and comparison.others == {}


def test_the_motion_is_that_of_a_long_simulation(comparison):
    run = comparison.runs[1]
    drive = SineDrive(run.cycle.frequency, run.cycle.base_amplitude, phase=run.cycle.phase)
    interval = 1 / run.cycle.frequency / 400
    long = simulate(nominal(RIG, ASSUMED, drive), samples=400 * 20, interval=interval)
    expected = outcome(
        np.asarray(long.x),
        interval=interval,
        frequency=run.cycle.frequency,
        natural_frequency=RIG.natural_frequency,
        cycles=4,
    )
    assert run.assumed.amplitude == pytest.approx(expected.amplitude, rel=2e-3)
    assert run.assumed.stops == expected.stops


def test_the_identified_constants_move_the_amplitude_to_the_recorded_one(comparison):
    for run in comparison.runs:
        off = {
            case: abs(getattr(run, case).amplitude - run.measured.amplitude)
            for case in ("identified", "assumed")
        }
        assert off["identified"] < 0.5 * off["assumed"]
        change = {name: abs(case.amplitude - run.assumed.amplitude) for name, case in run.exchanged.items()}
        assert change["C"] > 10 * change["D"]


def test_runs_rig_and_assumed_constants_may_come_from_elsewhere(saved):
    plan = RunPlan(file="new.csv", frequency=1.2, base_amplitude=0.008, rig=RIG, assumed=TRUE)
    silent = RunPlan(file="silent.csv", frequency=1.2, rig=RIG, assumed=TRUE)
    found = compare(saved, sheet(plan, silent, assumed=TRUE))
    (run,) = found.runs
    assert (run.file, run.cycle.frequency, run.measured) == ("new.csv", 1.2, None)
    assert "silent.csv" in found.notices[0]
    assert found.constants["C"]["assumed"] == TRUE.C and found.constants["C"]["inside"]
    assert run.assumed is not None
    assert run.identified.amplitude == pytest.approx(run.assumed.amplitude, rel=5e-3)


def test_without_assumed_constants_only_the_identified_motion_is_shown(saved):
    nothing = AssumedConstants()
    plan = RunPlan(file="new.csv", frequency=1.2, base_amplitude=0.008, rig=RIG, assumed=nothing)
    found = compare(saved, sheet(plan, assumed=nothing))
    (run,) = found.runs
    assert run.assumed is None and run.exchanged is None and run.identified.amplitude > 0.005
    assert "not assumed" in found.notices[0]
    assert found.constants["A"]["ratio"] is None and found.constants["A"]["remark"] == ""


def test_effects_and_freed_parameters_take_part_together(saved):
    """A freed mass shifts every run's own mass; an effect at its null value changes nothing."""
    key = next(iter(catalogue()))
    (effect,) = effects_at_null((key,)).values()
    null = {f"{key}.{place.path[-1]}": float(place.of(effect)) for place in parameters(effect)}
    blank = {"low": None, "high": None, "unit": "1", "assumed": None, "standard_error": None}
    plan = RunPlan(file="new.csv", frequency=1.2, base_amplitude=0.008, rig=RIG, assumed=ASSUMED)
    heavy = dataclasses.replace(plan, rig=dataclasses.replace(RIG, mass=2.5))
    others = {name: blank | {"value": value} for name, value in null.items()}
    both = compare(
        dataclasses.replace(saved, others=others | {"rig.mass": blank | {"value": 2.5, "assumed": 2.38}}),
        sheet(plan),
    )
    assert both.others["rig.mass"]["ratio"] == pytest.approx(2.5 / 2.38)
    (run,) = both.runs
    assert run.exchanged is not None and OTHERS in run.exchanged
    alone = compare(dataclasses.replace(saved, others={}), sheet(heavy)).runs[0]
    assert alone.assumed is not None
    assert run.exchanged[OTHERS].amplitude == pytest.approx(alone.assumed.amplitude, rel=1e-9)
    assert run.identified.amplitude == pytest.approx(alone.identified.amplitude, rel=1e-9)


def test_runs_without_a_sine_leave_the_numbers(saved):
    undriven = tuple(dataclasses.replace(run, cycle=None) for run in saved.runs)
    found = compare(dataclasses.replace(saved, runs=undriven))
    assert found.runs == () and "run-01.csv" in found.notices[0]
    assert found.constants["k1"]["inside"] is False
