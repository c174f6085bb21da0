"""The runs of a data set or of a rig.toml as the assumed constants predict them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from jaxstick.errors import UserError
from jaxstick.nominal import nominal
from jaxstick.oscillator import Start
from jaxstick.parts.drive import SineDrive
from jaxstick.record import DataSet, KnownRig, Noise, RigSheet, Run, RunPlan
from jaxstick.side_by_side import Journey, side_by_side
from jaxstick.simulate import simulate
from jaxstick.simulations import simulations
from tests.jaxstick.rig1987_runs import RIG, constants

ASSUMED = constants(0.86)


def plan(file: str, **given) -> RunPlan:
    return RunPlan(file=file, **({"rig": RIG, "assumed": ASSUMED} | given))


def sheet(*plans: RunPlan) -> RigSheet:
    return RigSheet(
        path=Path("rig.toml"),
        name="rig",
        rig=RIG,
        assumed=ASSUMED,
        noise=Noise(),
        runs=plans,
        notices=(),
        sha256="0",
    )


LISTED = sheet(
    plan("run-01.csv", frequency=1.5, base_amplitude=0.01, cycles=2.0, sample_rate=200.0),
    plan("run-02.csv", frequency=0.9, base_amplitude=0.012, base_phase=0.7, duration=1.5, sample_rate=200.0),
    plan(
        "run-03.csv",
        frequency=2.0,
        base_amplitude=0.01,
        cycles=2.5,
        sample_rate=250.0,
        rig=dataclasses.replace(RIG, mass=2.0),
        assumed=constants(0.9),
    ),
)


@pytest.fixture(scope="module")
def simulated() -> DataSet:
    return simulations(LISTED)


def test_listed_runs_are_those_of_simulate_each_on_its_own(simulated):
    for run, plan in zip(simulated.runs, LISTED.runs, strict=True):
        drive = SineDrive(plan.frequency or 0.0, plan.base_amplitude or 0.0, phase=plan.base_phase)
        alone = simulate(nominal(plan.rig, plan.assumed, drive), samples=len(run.time), interval=run.interval)
        np.testing.assert_allclose(run.displacement, alone.displacement, atol=2e-7)
        np.testing.assert_allclose(run.friction, alone.friction, atol=0.05)
        np.testing.assert_allclose(run.base, drive.at(run.time).y, atol=1e-15)
    assert [len(run.time) for run in simulated.runs] == [268, 301, 313]
    assert simulated.runs[1].base_phase == 0.7


def test_a_listed_run_lasts_ten_cycles_sampled_finely_unless_it_says_otherwise():
    slow, fast = simulations(
        sheet(
            plan("slow.csv", frequency=0.5, base_amplitude=0.01),
            plan("fast.csv", frequency=20.0, base_amplitude=0.01),
        )
    ).runs
    assert (slow.time[0], slow.time[-1]) == pytest.approx((0.0, 20.0), abs=slow.interval)
    assert 1 / slow.interval == pytest.approx(100 * RIG.natural_frequency)
    assert fast.time[-1] == pytest.approx(0.5, abs=fast.interval)
    assert 1 / fast.interval == pytest.approx(4000.0)


def test_recorded_runs_go_on_as_their_first_samples_say(simulated):
    """A record cut out of a simulation is simulated back, whether driven by the recorded base or as stated,
    with or without the friction force."""
    whole = simulated.runs[0]
    cut = slice(61, None)
    records = [
        dataclasses.replace(
            whole,
            file=f"{number}.csv",
            time=whole.time[cut],
            displacement=whole.displacement[cut],
            base=None if base is None else base[cut],
            friction=None if friction is None else friction[cut],
        )
        for number, (base, friction) in enumerate(
            ((whole.base, whole.friction), (whole.base, None), (None, whole.friction))
        )
    ]
    data = DataSet(name="cut", rig=RIG, assumed=ASSUMED, runs=tuple(records))
    for record, again in zip(records, simulations(data).runs, strict=True):
        np.testing.assert_array_equal(again.time, record.time)
        np.testing.assert_allclose(again.displacement, record.displacement, atol=1.5e-4)
        assert np.std(again.displacement - record.displacement) < 5e-5


def test_a_force_drives_a_mass_without_springs():
    """m v' = u - C under a force that exceeds C: the closed form of constant friction."""
    free = KnownRig(2.0, 0.0, 0.0, 0.0, 0.0)
    sliding = dataclasses.replace(ASSUMED, A=0.0, B=1.0, C=3.0, D=0.0, k1=1e5)
    time = np.linspace(0.0, 1.0, 201)
    record = Run(
        file="run-01.csv",
        time=time,
        displacement=0.1 + 0.5 * time**2,
        force=np.full_like(time, 5.0),
        rig=free,
        assumed=sliding,
    )
    (run,) = simulations(DataSet(name="free", rig=free, assumed=sliding, runs=(record,))).runs
    assert run.base is None
    np.testing.assert_array_equal(run.force, record.force)
    np.testing.assert_allclose(run.displacement, record.displacement, atol=1e-4)
    assert run.friction is not None and run.friction[-1] == pytest.approx(-3.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"base_amplitude": 0.01}, "has no frequency_hz"),
        ({"frequency": 1.0}, "has no base_amplitude_mm"),
        ({"frequency": 1.0, "base_amplitude": 0.01, "cycles": 1e9}, "samples"),
        ({"frequency": 1.0, "base_amplitude": 0.01, "duration": 1e-9}, "less than one interval"),
        (
            {
                "frequency": 1.0,
                "base_amplitude": 0.01,
                "assumed": dataclasses.replace(ASSUMED, k1=None),
            },
            "does not give k1",
        ),
        (
            {"frequency": 1.0, "base_amplitude": 0.01, "assumed": dataclasses.replace(ASSUMED, k1=1e18)},
            "integration steps",
        ),
    ],
)
def test_a_run_that_cannot_be_simulated_is_refused_in_a_sentence(given, words):
    with pytest.raises(UserError, match=words):
        simulations(sheet(plan("run-01.csv", **given)))


def test_a_rig_without_runs_is_refused():
    with pytest.raises(UserError, match=r"no run is listed"):
        simulations(sheet())


def test_lanes_come_back_in_order_whatever_their_kind_and_length():
    drives = [SineDrive(1.5, 0.01), SineDrive(1.0, 0.005)]
    journeys = [
        Journey(
            nominal(dataclasses.replace(RIG, friction_against=against), ASSUMED, drive), Start(), 0.0, dt, n
        )
        for drive, against, dt, n in zip(
            (*drives, drives[0]),
            ("ground", "base", "ground"),
            (0.004, 0.005, 0.004),
            (40, 70, 20),
            strict=True,
        )
    ]
    first, second, third = side_by_side(journeys)
    assert [len(found.x) for found in (first, second, third)] == [40, 70, 20]
    np.testing.assert_array_equal(first.x[:20], third.x)
    assert second.time[-1] == pytest.approx(69 * 0.005)
    assert np.ptp(second.x) != np.ptp(first.x)


def test_the_lane_with_the_longest_interval_sets_the_steps():
    oscillator = nominal(RIG, ASSUMED, SineDrive(1.5, 0.01))
    coarse, fine = side_by_side(
        [Journey(oscillator, Start(), 0.0, 0.04, 21), Journey(oscillator, Start(), 0.0, 0.001, 801)]
    )
    np.testing.assert_allclose(coarse.x, fine.x[::40], atol=2e-6)
