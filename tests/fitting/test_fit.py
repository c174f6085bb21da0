"""The whole fit against truths: the independent reference's records, and jaxstick's own where only it can."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np
import pytest

from fitting.fit import fit
from fitting.result import Constant, Fit
from fitting.settings import Settings
from jaxstick.effects.asymmetric_friction import AsymmetricFriction
from jaxstick.effects.constant_force import ConstantForce
from jaxstick.errors import UserError
from jaxstick.parts.drive import SineDrive
from jaxstick.record import DataSet, Run
from tests.fitting.reference_data import (
    NOISE,
    RATIOS,
    RIG,
    TRUTH,
    WRONG,
    dataset,
    exact_run,
    noisy,
    own_run,
)

QUICK = Settings(starts=3, descent_iterations=25, horizon=2.0)
BOUNDED = ("A", "B", "C", "k1")


def fitted(data: DataSet, **changes) -> Fit:
    """The fit; optax counts on jax's ordinary promotion of types."""
    with jax.numpy_dtype_promotion("standard"), jax.numpy_rank_promotion("allow"):
        return fit(data, dataclasses.replace(QUICK, **changes))


def by_name(result: Fit) -> dict[str, Constant]:
    return {constant.name: constant for constant in (*result.constants, *result.others)}


def standard_errors_off(constant: Constant, truth: float) -> float:
    assert constant.standard_error is not None
    return abs(constant.value - truth) / constant.standard_error


def covers(constant: Constant, truth: float) -> bool:
    return (constant.low is None or constant.low <= truth) and (
        constant.high is None or truth <= constant.high
    )


def width(constant: Constant) -> float:
    assert constant.low is not None and constant.high is not None
    return constant.high - constant.low


def seeded(*runs: Run, seed: int = 1987) -> tuple[Run, ...]:
    random = np.random.default_rng(seed)
    return tuple(noisy(run, random) for run in runs)


REFERENCE_RUNS = tuple(exact_run(ratio) for ratio in RATIOS)


@pytest.fixture(scope="module")
def found() -> Fit:
    """The fit of two noisy runs of the reference, from the right constants."""
    return fitted(dataset(*seeded(*REFERENCE_RUNS)))


def test_the_truth_lies_in_every_interval(found):
    assert found.outcome == "converged"
    for name, constant in by_name(found).items():
        assert covers(constant, TRUTH[name]), constant
        if name in BOUNDED:
            assert constant.identifiable
            assert standard_errors_off(constant, TRUTH[name]) < 4, constant
            assert constant.standard_error is not None and constant.standard_error < 0.1 * TRUTH[name]


def test_a_viscous_slope_far_below_the_noise_is_not_identifiable(found):
    D = by_name(found)["D"]
    assert D.low is None and not D.identifiable
    assert D.method == "profile"
    assert D.high is not None and TRUTH["D"] < D.high < 1.0


def test_what_is_left_is_the_noise(found):
    assert 0.9 < found.chi2_per_sample < 1.1
    assert found.excluded_segments == 0
    assert [free.file for free in found.free_runs] == [run.file for run in REFERENCE_RUNS]
    for free in found.free_runs:
        assert free.floor == NOISE.displacement
        assert 0.9 < free.rms_displacement / free.floor < 1.3
    assert len(found.gaps) == 4
    for gap in found.gaps:
        assert 0.9 < gap.rms / gap.floor < 1.1, gap


def test_assumed_constants_wrong_by_three_lead_to_the_same_answer(found):
    other = fitted(dataset(*seeded(*REFERENCE_RUNS), assumed=WRONG))
    assert other.outcome == "converged"
    for name in BOUNDED:
        one, two = by_name(found)[name], by_name(other)[name]
        assert two.assumed == getattr(WRONG, name)
        assert one.standard_error is not None
        assert abs(one.value - two.value) < 0.3 * one.standard_error, name
        assert width(two) == pytest.approx(width(one), rel=0.2)


def test_a_held_out_run_is_accounted_for_and_never_used():
    kept, held = seeded(*REFERENCE_RUNS)
    held = dataclasses.replace(held, hold_out=True)
    one = fitted(dataset(kept, held))
    bent = dataclasses.replace(held, displacement=1.5 * held.displacement, friction=None)
    two = fitted(dataset(kept, bent))
    for a, b in zip(one.constants, two.constants, strict=True):
        assert (a.value, a.low, a.high) == (b.value, b.low, b.high)
    assert [free.file for free in one.free_runs] == [kept.file, held.file]
    assert [trace.run.file for trace in one.traces] == [kept.file, held.file]
    assert one.free_runs[1].rms_displacement < 1.3 * one.free_runs[1].floor
    assert two.free_runs[0] == one.free_runs[0]
    assert two.free_runs[1].rms_displacement > 50 * one.free_runs[1].rms_displacement


def test_displacement_alone_is_enough_for_A_B_C():
    runs = (dataclasses.replace(run, friction=None) for run in seeded(*REFERENCE_RUNS))
    result = fitted(dataset(*runs))
    constants = by_name(result)
    assert {gap.channel for gap in result.gaps} == {"displacement"}
    assert 0.9 < result.chi2_per_sample < 1.1
    for name in ("A", "B", "C"):
        assert standard_errors_off(constants[name], TRUTH[name]) < 4, constants[name]
    assert constants["C"].value == pytest.approx(TRUTH["C"], rel=0.02)


def test_effects_that_made_the_data_are_recovered():
    truth = {"constant_force.force": 0.4, "asymmetric_friction.dry": 0.08}
    truth |= dict.fromkeys(("asymmetric_friction.viscous", "asymmetric_friction.steady"), 0.0)
    effects = {
        "constant_force": ConstantForce(force=0.4),
        "asymmetric_friction": AsymmetricFriction(dry=0.08),
    }
    runs = seeded(own_run(SineDrive(1.5, 10.325e-3), effects=effects))
    result = fitted(dataset(*runs), effects=("constant_force", "asymmetric_friction"))
    constants = by_name(result)
    assert tuple(constant.name for constant in result.others) == tuple(truth)
    assert 0.9 < result.chi2_per_sample < 1.1
    for name in ("constant_force.force", "asymmetric_friction.dry"):
        assert standard_errors_off(constants[name], truth[name]) < 5, constants[name]
        assert constants[name].low > 0, "the data exclude that it is absent"  # pyright: ignore[reportOptionalOperand]
    for name in BOUNDED:
        assert standard_errors_off(constants[name], TRUTH[name]) < 5, constants[name]


def test_a_mass_one_percent_heavier_than_stated_is_found():
    heavier = dataclasses.replace(RIG, mass=1.01 * RIG.mass)
    runs = seeded(own_run(SineDrive(1.5, 10.325e-3), rig=heavier))
    mass = by_name(fitted(dataset(*runs), free=("mass",)))["rig.mass"]
    assert mass.unit == "kg" and mass.assumed == RIG.mass
    assert standard_errors_off(mass, heavier.mass) < 5
    assert mass.low > RIG.mass, "the data exclude the stated mass"  # pyright: ignore[reportOptionalOperand]


def test_a_rig_without_springs_driven_by_a_force():
    free = dataclasses.replace(RIG, stiffness=0.0, drive_stiffness=0.0, damping=0.0)
    runs = seeded(own_run(SineDrive(2.0, force_amplitude=12.0), rig=free, samples=1000))
    result = fitted(dataset(*runs, rig=free))
    constants = by_name(result)
    assert 0.9 < result.chi2_per_sample < 1.1
    for name in BOUNDED:
        assert standard_errors_off(constants[name], TRUTH[name]) < 5, constants[name]


def first_samples(run: Run, count: int) -> Run:
    channels = {name: samples[:count] for name, samples in run.channels.items()}
    return dataclasses.replace(run, time=run.time[:count], **channels)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"free": ("nonsense",)}, r"'nonsense' is not a parameter of the rig.*mass, stiffness"),
        ({"free": ("drive_damping",)}, r"'drive_damping' is stated as 0"),
        ({"effects": ("constant_farce",)}, r"did you mean 'constant_force'"),
    ],
)
def test_settings_that_do_not_suit_are_refused(changes, message):
    with pytest.raises(UserError, match=message):
        fitted(dataset(*REFERENCE_RUNS), **changes)


@pytest.mark.parametrize("count", [4, 9, 11])
def test_a_run_too_short_for_a_segment_is_refused(count):
    short = first_samples(seeded(REFERENCE_RUNS[0])[0], count)
    with pytest.raises(UserError, match=rf"ratio-0\.326\.csv: {count} samples are fewer than the 12"):
        fitted(dataset(short))
