"""What a fit is about: bounds of the constants, and where descents begin."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.diagnosis.lanes.model import Model
from fitting.problem import beginnings, pose
from fitting.settings import Settings
from jaxstick.effects.mains_hum import MainsHum
from jaxstick.record import CONSTANTS, AssumedConstants
from tests.fitting.reference_data import RIGHT, dataset, exact_run

POWERS = st.floats(-4.0, 4.0)


@given(POWERS, POWERS)
def test_a_descent_begins_at_what_is_assumed_however_far_from_what_the_data_show(sharper, stiffer):
    """A contact so stiff, or a weakening at so low a speed, that the records do not show it by themselves."""
    stated = {name: float(getattr(RIGHT, name)) for name in CONSTANTS}
    stated["B"] *= 10.0**sharper
    stated["k1"] *= 10.0**stiffer
    settings = Settings(starts=2)
    problem = pose(dataset(exact_run(0.326), assumed=AssumedConstants(**stated)), settings)
    _, assumed = beginnings(problem, settings)
    begun = [unknown.to_value(at) for unknown, at in zip(problem.unknowns.members, assumed, strict=True)]
    np.testing.assert_allclose(begun, [stated[name] for name in CONSTANTS], rtol=1e-9)
    for unknown in problem.unknowns.members:
        assert unknown.lower <= stated[unknown.name] / 2 and unknown.upper >= 2 * stated[unknown.name]


def test_nothing_assumed_leaves_what_the_data_show():
    bare = AssumedConstants(**dict.fromkeys(CONSTANTS))
    problem = pose(dataset(exact_run(0.326), assumed=bare), Settings())
    force, travel = problem.scale.force, problem.scale.displacement
    k1 = problem.unknowns.members[-1]
    assert (k1.lower, k1.upper) == pytest.approx((force / travel, 5000 * force / travel))


def test_a_shape_that_may_go_either_way_begins_at_nought_and_may_be_less():
    problem = pose(dataset(exact_run(0.326)), Settings(effects=("mains_hum", "periodic_track")))
    hum = problem.hypothesis.effects["mains_hum"]
    assert isinstance(hum, MainsHum) and hum.second_even == 0
    kinds = {unknown.name: unknown for unknown in problem.unknowns.members}
    even, wavelength = kinds["mains_hum.second_even"], kinds["periodic_track.wavelength"]
    assert (even.kind, even.lower, even.upper) == ("linear", -1.0, 1.0)
    assert wavelength.kind == "log"


def test_what_was_forgotten_may_be_many_times_what_a_rig_has_on_which_friction_is_small():
    """A rig whose friction is a thousandth of what its springs bear."""
    data = dataset(exact_run(0.326))
    rig = dataclasses.replace(data.rig, stiffness=1e3 * data.rig.stiffness, damping=1e3 * data.rig.damping)
    free = ("base_relative_damping", "cubic_stiffness", "quadratic_drag", "stiffness_error")
    problem = pose(dataclasses.replace(data, rig=rig), Settings(effects=free))
    stroke, speed = problem.scale.displacement, problem.scale.speed
    has = {
        "base_relative_damping.damping": rig.damping,
        "cubic_stiffness.coefficient": rig.stiffness / stroke**2,
        "quadratic_drag.coefficient": rig.damping / speed,
        "stiffness_error.stiffness": rig.stiffness,
    }
    bounds = {unknown.name: (unknown.lower, unknown.upper) for unknown in problem.unknowns.members}
    for name, amount in has.items():
        assert bounds[name][1] == pytest.approx(10 * amount)


@pytest.mark.parametrize("free", [("force_clipping", "force_delay"), ("force_delay", "force_clipping")])
def test_faults_of_the_measuring_chain_follow_those_stated_in_the_order_in_which_they_are_named(free):
    data = dataclasses.replace(dataset(exact_run(0.326)), effects={"mains_hum": {}, "end_stop": {}})
    problem = pose(data, Settings(effects=(*free, "cubic_stiffness")))
    assert [key for key in problem.hypothesis.order if key.startswith(("force", "mains"))] == [
        "mains_hum",
        *free,
    ]
    model = Model(problem, 1)
    assert model.at(model.origin({}), ()).order == problem.hypothesis.order
