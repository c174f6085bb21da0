"""Programs are compiled ahead of their use, in the shapes in which they are used."""

from __future__ import annotations

import dataclasses
import queue
from typing import Any

import jax
import numpy as np
import pytest

from fitting.diagnosis.lanes import model as module
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Job, Model
from fitting.diagnosis.lanes.programs import COLUMNS
from fitting.diagnosis.lanes.wander import OWN
from jaxstick.parts.bend import SPAN
from jaxstick.parts.drive import SineDrive
from jaxstick.record import AssumedConstants
from tests.fitting.diagnosis.grounded import laid_out
from tests.fitting.reference_data import RIG, TRUTH, dataset, own_run


@pytest.fixture(scope="module")
def laid() -> tuple[Model, Bench]:
    return laid_out(dataset(own_run(SineDrive(1.5, 10.325e-3), samples=600)))


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> queue.Queue[Any]:
    """What programs are asked for: effects, structure and shapes of their arguments; none is compiled."""
    found: queue.Queue[Any] = queue.Queue()

    class Asked:
        def program(self, *args: Any) -> None:
            leaves, structure = jax.tree.flatten(args)
            found.put((set(args[0].effects), structure, [np.shape(leaf) for leaf in leaves]))
            raise ArithmeticError

    monkeypatch.setattr(module, "columns", Asked())
    return found


@pytest.mark.parametrize("against", ["ground", "base"])
def test_a_mass_slides_over_its_guide_which_the_base_may_carry(against: str):
    run = own_run(SineDrive(3.0, 10.325e-3), samples=600)
    model, bench = laid_out(dataset(run, rig=dataclasses.replace(RIG, friction_against=against)))
    lanes, counts = bench.lanes, bench.share[:, :, 0] > 0
    place, rate = model.sliding(lanes, np.asarray(lanes.displacement), np.zeros(counts.shape))
    begins, intervals = np.asarray(lanes.start_time), np.asarray(lanes.interval)
    time = begins[:, None] + intervals[:, None] * np.arange(counts.shape[1])
    assert run.base is not None
    carried = np.interp(time, run.time, run.base) if against == "base" else np.zeros(time.shape)
    speed = np.interp(time, run.time, np.gradient(run.base, run.interval, edge_order=2)) * (against == "base")
    assert (np.asarray(lanes.displacement) - place)[counts] == pytest.approx(carried[counts], abs=1e-5)
    assert -rate[counts] == pytest.approx(speed[counts], abs=2e-3)


def test_what_is_compiled_ahead_is_what_is_used(laid, asked):
    model, bench = laid
    groups, count = model.sharing.groups[:2], len(bench.lanes)
    with model.ahead(bench.lanes, groups):
        ahead = [asked.get(timeout=30) for _ in groups]
    each, own = np.tile(model.origin(TRUTH), (count, 1)), np.asarray(bench.lanes.start)
    chosen = np.tile(np.arange(COLUMNS), (count, 1))
    for group, before in zip(groups, ahead, strict=True):
        with pytest.raises(ArithmeticError):
            model.columns([Job(group, bench.lanes, np.ones((count, OWN)), each, own, chosen)])
        assert asked.get(timeout=30) == before and before[0] == {*group}
    assert own.shape[1] == OWN


def test_traces_are_those_in_the_channels_that_were_recorded(laid):
    run = dataclasses.replace(own_run(SineDrive(1.5, 10.325e-3), samples=600), friction=None)
    moved, _ = laid_out(dataset(run))
    both = [model.shelf.traces for model in (laid[0], moved)]
    gains = [[traces[key] for key in ("force_gain", "displacement_gain", "base_gain")] for traces in both]
    forces, drive = ("scale of the forces",), ("scale of the drive",)
    assert gains == [[forces, forces, drive], [(), drive, drive]]
    assert [traces["stiffness_error"] for traces in both] == [forces + drive, drive]
    assert both[0]["base_delay"] == both[1]["base_delay"] != ()


def test_a_shape_that_may_go_either_way_is_searched_about_nought(laid):
    model, _ = laid
    signed, other = model.index("mains_hum.second_odd", "periodic_track.wavelength")
    assert model.origin(TRUTH)[signed] == 0
    bend = model.index("force_gain.bend")
    np.testing.assert_allclose(model.upper[bend], SPAN[1])
    assert all(-np.inf < model.lower[one] == -model.upper[one] < -1 for one in (signed, *bend))
    values = model.values(np.full(len(model.names) + 1, -0.5), ("mains_hum.second_odd",))
    assert values["mains_hum.second_odd"] < 0
    assert (model.members[signed].kind, model.members[other].kind) == ("linear", "log")
    cost, slope, curvature = model.prior(np.array([0.5, -0.5]), np.array([signed, signed]))
    assert cost > 0 and slope[0] == -slope[1] > 0 and (curvature > 0).all()


def test_a_strength_goes_as_far_as_its_span(laid):
    """In typical sizes: what settles soon changes fast at first."""
    model, _ = laid
    rate, offset = model.index("force_drift.rate", "force_offset.offset")
    np.testing.assert_allclose(model.upper[[rate, offset]], [1e3, 50])
    np.testing.assert_allclose(model.lower[[rate, offset]], [-1e3, -50])


def test_what_was_forgotten_may_be_many_times_what_is_stated():
    """On a rig of little friction too; what is there cannot all be missing."""
    sliding = {name: TRUTH[name] / 50 for name in ("A", "C", "D")}
    constants = AssumedConstants(**{**TRUTH, **sliding})
    run = own_run(SineDrive(1.5, 10.325e-3), constants=constants, samples=600)
    model, _ = laid_out(dataset(run, assumed=constants))
    stroke, speed = 10e-3, 2 * np.pi * 1.5 * 10e-3
    for name, stated in (
        ("base_relative_damping.damping", RIG.damping),
        ("quadratic_drag.coefficient", RIG.damping / speed),
        ("cubic_stiffness.coefficient", RIG.stiffness / stroke**2),
        ("stiffness_error.mass", RIG.mass),
        ("stiffness_error.stiffness", RIG.stiffness),
    ):
        (number,) = model.index(name)
        member = model.members[number]
        assert -stated < member.lower and member.upper > 5 * stated
        assert member.to_value(model.upper[number]) == pytest.approx(member.upper)


def test_one_core_has_no_time_for_that(laid, asked, monkeypatch):
    model, bench = laid
    monkeypatch.setattr(model, "workers", 1)
    with model.ahead(bench.lanes, model.sharing.groups):
        pass
    assert asked.empty()
