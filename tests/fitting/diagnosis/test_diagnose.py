"""The diagnosis as a whole, on small data sets whose truth is known."""

from __future__ import annotations

import dataclasses
import types
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from fitting.diagnosis import diagnose as whole
from fitting.diagnosis.accounts import Account
from fitting.diagnosis.diagnose import diagnose
from fitting.diagnosis.findings import Closure, Diagnosis, Yardstick
from fitting.diagnosis.inquiry import confirmed
from fitting.diagnosis.judging.judge import judge
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.ground import ground
from fitting.diagnosis.refits.refit import refit
from fitting.diagnosis.save import save_diagnosis
from fitting.diagnosis.settings import DiagnosisSettings
from fitting.diagnosis.which.attribute import Attribution
from fitting.problem import pose
from fitting.progress import Silent
from fitting.settings import Settings
from jaxstick.catalogue import catalogue
from jaxstick.effect import AbstractEffect
from jaxstick.effects.cubic_stiffness import CubicStiffness
from jaxstick.errors import UserError
from jaxstick.output import OutputFolder
from jaxstick.parts.drive import SineDrive
from jaxstick.record import DataSet, load_rig
from jaxstick.simulations import simulations
from tests.fitting.reference_data import RIG, TRUTH, WRONG, dataset, noisy, own_run

COEFFICIENT = 1.2e6
DRIVES = (0.8, 1.5, 2.6, 3.8)
SETTLING = 3.0
"""Seconds after which the motion repeats itself: what does not is weighed as scatter."""
HELD_OUT = "run-2.csv"


def records(coefficient: float, seed: int) -> DataSet:
    """Four noisy runs of the 1987 rig, in steady state, whose spring hardens by this coefficient [N/m^3]."""
    random = np.random.default_rng(seed)
    effects: dict[str, AbstractEffect] = {"hardening": CubicStiffness(coefficient)} if coefficient else {}
    drives = [SineDrive(f, 10.325e-3) for f in DRIVES]
    runs = [
        noisy(own_run(drive, effects=effects, samples=700, settling=SETTLING, file=f"run-{n}.csv"), random)
        for n, drive in enumerate(drives)
    ]
    return dataset(*runs, assumed=WRONG)


@pytest.fixture(scope="module")
def hardened() -> Diagnosis:
    return diagnose(records(COEFFICIENT, 1), DiagnosisSettings(hold_out=(HELD_OUT,), workers=2))


@pytest.fixture(scope="module")
def plain() -> Diagnosis:
    return diagnose(records(0.0, 2), DiagnosisSettings(hold_out=(HELD_OUT,), workers=2))


KEY = next(iter(catalogue()))


def once_confirmed(nominal: float, account: Account, samples: float, shrunk: Closure) -> str:
    """The verdict on records in which the nominal model leaves this misfit and the one effect that explains
    them, which is named, what the account says, once runs that took no part have spoken."""
    judgement = judge(nominal, [account], samples, 1.5, list(catalogue()))
    assert (judgement.verdict, judgement.named) == ("effect", account.keys)
    named: Any = types.SimpleNamespace(
        keys=account.keys, refit=types.SimpleNamespace(cost=np.array([account.misfit]))
    )
    left: Any = types.SimpleNamespace(cost=np.array([nominal]), misfit=nominal)
    screen: Any = None
    against = Yardstick(nominal, 1.0, samples, 1.5, accounts=(account,))
    found = Attribution(left, (), screen, judgement, against)
    return confirmed(found, named, shrunk).verdict


@pytest.mark.parametrize(
    ("nominal", "after", "verdict"),
    [(1.2, 1.02, "unlisted"), (1.2, 1.001, "effect"), (1.2, 0.98, "effect"), (1.09, 1.001, "none")],
)
def test_what_makes_it_worse_where_it_was_not_fitted_is_not_the_cause(nominal, after, verdict):
    """Off the shelf where there is a gap to be explained, nothing where there is none."""
    shrunk = Closure(1.0, after, 0.97, 2.0, 0.0, (-0.5, 0.5), 0.0, 0.0, (HELD_OUT,), False)
    assert once_confirmed(nominal, Account((KEY,), 0.9, 1), 16000.0, shrunk) == verdict


@pytest.mark.parametrize(
    ("nominal", "before", "closed", "verdict"),
    [
        (0.98, 1.3, 0.19, "none"),
        (0.98, 1.3, 0.6, "effect"),
        (0.98, 1.1, 0.19, "effect"),
        (1.2, 1.3, 0.19, "effect"),
    ],
)
def test_what_only_makes_friction_steadier_closes_a_gap_that_is_there(nominal, before, closed, verdict):
    """Of an effect that is named for that, where what was fitted shows no gap, other runs may show one."""
    shrunk = Closure(
        before, 1.28, 1.0, 2.0, 0.09, (0.0, closed), 0.0, 0.0, (HELD_OUT,), False, gain=0.7, steadier=20.0
    )
    assert once_confirmed(nominal, Account((KEY,), 0.95, 1, steadier=25.0), 200.0, shrunk) == verdict


def test_the_cause_is_named_with_its_size(hardened):
    assert hardened.verdict in ("effect", "ambiguous")
    assert hardened.named[0] == "cubic_stiffness"
    assert hardened.probabilities["cubic_stiffness"] > 0.6
    (coefficient,) = hardened.effects["cubic_stiffness"]
    assert coefficient.low < COEFFICIENT < coefficient.high
    assert coefficient.high - coefficient.low < 0.3 * COEFFICIENT
    assert "cubic_stiffness" in hardened.sentence and "cubic_stiffness" in hardened.cards


def test_an_effect_that_is_stated_is_part_of_the_model():
    """The nominal model then has it, leaves nothing but noise, and does not look for it again."""
    stated = {"cubic_stiffness": {"coefficient": COEFFICIENT}}
    data = dataclasses.replace(records(COEFFICIENT, 1), effects=stated)
    settings = Settings(workers=2)
    problem = pose(data, settings)
    model = Model(problem, settings.workers)
    base = ground(problem, model, settings, Silent())
    (nominal,) = refit(model, base.bench, [base.point], [model.nuisances()])
    assert nominal.misfit < 1.1
    assert "cubic_stiffness" not in model.shelf.effects


def test_the_gap_closes_on_the_run_that_took_no_part(hardened):
    gap = hardened.closure
    assert gap.held_out == (HELD_OUT,) and not gap.by_segments
    assert gap.before > 1.3 and gap.after == pytest.approx(1.0, abs=0.1)
    assert gap.closed > 0.9
    assert gap.interval[0] < gap.closed < gap.interval[1]
    assert gap.placebo is not None and abs(gap.placebo) < 0.3
    assert gap.wrong is not None and gap.wrong < gap.closed
    (wrong,) = gap.wrong_keys
    assert wrong in hardened.cards and wrong not in hardened.named
    assert gap.assumed is not None and gap.assumed > gap.before


def test_the_constants_are_right_with_the_effect_in(hardened):
    for constant in hardened.constants:
        if constant.name in ("B", "C", "k1"):
            assert constant.standard_error is not None
            assert abs(constant.value - TRUTH[constant.name]) < 5 * constant.standard_error


def test_the_rig_is_found_within_its_tolerance(hardened):
    found = {constant.name: constant for constant in hardened.others}
    units = {"mass": "kg", "stiffness": "N/m", "drive_stiffness": "N/m", "damping": "N s/m"}
    assert set(found) == {f"rig.{name}" for name in units}
    for name, unit in units.items():
        constant = found[f"rig.{name}"]
        assert constant.unit == unit and constant.assumed == getattr(RIG, name)
    for constant in (found["rig.mass"], found["rig.stiffness"]):
        assert constant.low is not None and constant.high is not None
        assert constant.low < constant.assumed < constant.high
        assert constant.high - constant.low < 0.04 * constant.assumed


def test_the_gap_is_where_the_spring_is(hardened):
    where = hardened.where
    for name in ("channel", "phase", "direction", "run", "harmonic", "time", "side"):
        shares = getattr(where, name)
        assert sum(shares.values()) == pytest.approx(1.0, abs=1e-9)
        assert all(0 <= share <= 1 for share in shares.values())
    assert max(where.side, key=lambda side: where.side[side]) == "mechanics"
    assert where.excess > 0.5 and where.significance > 3
    assert set(where.run) == {f"run-{n}.csv" for n in range(len(DRIVES))}


def test_the_named_explanation_is_kept_as_a_rig(hardened, tmp_path):
    correction = hardened.correction
    assert correction is not None
    (coefficient,) = hardened.effects["cubic_stiffness"]
    assert correction.effects == {"cubic_stiffness": {"coefficient": coefficient.value}}
    for constant in hardened.constants:
        assert getattr(correction.constants, constant.name) == pytest.approx(constant.value, rel=1e-12)
    for name, tolerance in (("mass", 0.025), ("stiffness", 0.01), ("damping", 0.5)):
        share = getattr(correction.rig, name) / getattr(RIG, name)
        assert share != 1 and abs(share - 1) <= tolerance
    assert correction.rig.drive_damping == 0.0

    data = records(COEFFICIENT, 1)
    with OutputFolder(tmp_path / "out") as output:
        save_diagnosis(hardened, data, output)
    sheet = load_rig(tmp_path / "out" / "corrected_rig.toml")
    assert (sheet.rig, sheet.assumed, sheet.effects) == (
        correction.rig,
        correction.constants,
        correction.effects,
    )
    (frequency, run), *_ = zip(DRIVES, simulations(sheet).runs, strict=True)
    assert len(run.time) == 700 and run.frequency == pytest.approx(frequency, rel=1e-3)


def test_records_without_an_effect_are_called_so(plain):
    assert plain.correction is None
    assert (plain.verdict, plain.named, plain.effects) == ("none", (), {})
    assert plain.probabilities["none"] > 0.8
    assert sum(plain.probabilities.values()) == pytest.approx(1.0)
    assert plain.closure.closed == 0.0
    assert plain.closure.before == pytest.approx(1.0, abs=0.1)


def test_every_effect_has_a_limit_and_the_cause_is_beyond_its_own(plain):
    limits = {f"{limit.effect}.{limit.strength}": limit for limit in plain.limits}
    assert {limit.effect for limit in plain.limits} == set(catalogue())
    assert limits["cubic_stiffness.coefficient"].value < COEFFICIENT
    assert all(limit.likest in set(catalogue()) - {limit.effect} for limit in plain.limits)


def test_the_traces_follow_the_records(hardened):
    assert [trace.file for trace in hardened.traces] == [f"run-{n}.csv" for n in range(len(DRIVES))]
    for trace in hardened.traces:
        before = np.std(trace.before_displacement - trace.displacement)
        after = np.std(trace.after_displacement - trace.displacement)
        assert after < 1.3 * trace.displacement_noise < 1.3 * before
    assert len(hardened.residual_force.force) == 4 * 700


def test_holding_out_what_is_not_there_or_everything_is_refused():
    data = records(0.0, 3)
    with pytest.raises(UserError, match=r"There is no run 'run-9.csv' to hold out; there are run-0.csv"):
        diagnose(data, DiagnosisSettings(hold_out=("run-9.csv",)))
    every = dataclasses.replace(
        data, runs=tuple(dataclasses.replace(run, hold_out=True) for run in data.runs)
    )
    with pytest.raises(UserError, match="held out no run is left to fit"):
        diagnose(every)


def test_blas_keeps_to_one_thread_while_a_diagnosis_shares_the_cores_itself(plain, monkeypatch):
    def threads(*_: object) -> Any:
        seen.append({pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"})
        return plain

    seen: list[set[int]] = []
    monkeypatch.setattr(whole, "_diagnosed", threads)
    with threadpool_limits(limits=2, user_api="blas"):
        diagnose(records(0.0, 3))
        threads()
    assert seen == [{1}, {2}]
