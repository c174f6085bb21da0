"""What the gap follows is found where it is known: on the right side, in the right pattern."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.findings import Patterns
from fitting.diagnosis.lanes.laying import lay_whole
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.where.clue import BEAT, FRICTION, MECHANICS, MOMENTS, MOTION, PATTERNS, Clue, clue_of
from fitting.diagnosis.where.pattern import FORMS, patterns
from fitting.problem import pose
from fitting.settings import Settings
from jaxstick.effect import AbstractEffect
from jaxstick.effects.cubic_stiffness import CubicStiffness
from jaxstick.effects.quadratic_drag import QuadraticDrag
from jaxstick.effects.stribeck_shape import StribeckShape
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Run
from tests.fitting.diagnosis.geared import GEAR, Gear
from tests.fitting.diagnosis.grounded import SUBSTEPS, WORKERS, from_the_truth
from tests.fitting.reference_data import TRUTH, dataset, noisy, own_run

FREQUENCIES = (0.9, 1.5, 2.1)


def held(run: Run) -> Run:
    """The run with a friction force that keeps a value now and then for a fortieth of a second and more."""
    assert run.friction is not None
    friction = run.friction.copy()
    for first in range(40, len(friction) - 40, 97):
        friction[first : first + 12] = friction[first]
    return dataclasses.replace(run, friction=friction)


def followed(
    effects: dict[str, AbstractEffect], *, silent: bool = False, lost: bool = False
) -> dict[str, Patterns]:
    """What is found on runs of the 1987 rig on which these effects act; the constants are fitted from the
    true ones on. `silent`: without the friction force; `lost`: the converter of the force holds values."""
    random, runs = np.random.default_rng(3), []
    for frequency in FREQUENCIES:
        drive = SineDrive(frequency, 10.325e-3)
        run = own_run(drive, effects=effects, samples=1500, file=f"run-{frequency}.csv")
        run = noisy(held(run) if lost else run, random)
        runs.append(dataclasses.replace(run, friction=None) if silent else run)
    problem = pose(dataset(*runs), Settings(workers=WORKERS))
    model, bench = Model(problem, WORKERS), lay_whole(problem, SUBSTEPS)
    point = from_the_truth(model, bench, (), model.origin(TRUTH)).point
    return patterns(problem, model, bench, point)


def test_a_force_that_oscillates_by_itself_is_found_with_its_frequency():
    """On the side of the mechanics, for the measured friction force has no part in it."""
    found = followed({"gear": Gear(0.3)})
    assert set(found) == {MECHANICS, FRICTION}
    side = found[MECHANICS]
    assert side.excess > 1 and side.significance > 5
    assert side.beat == pytest.approx(GEAR, abs=0.02)
    assert next(iter(side.shares)) == "beat" and side.shares["beat"] > 0.8
    assert all(share < 0.2 for name, share in side.shares.items() if name not in ("beat", "moments"))
    clue = clue_of(found)
    assert clue is not None and (clue.side, clue.pattern) == (MECHANICS, "beat")
    assert f"oscillates at {side.beat:.4g} Hz" in clue.clause and f"at {side.beat:.4g} Hz" in clue.look


@pytest.mark.parametrize(
    ("effect", "side", "pattern", "not_of"),
    [
        (CubicStiffness(4e5), MECHANICS, "place", "against the motion, by place"),
        (QuadraticDrag(6.0), MECHANICS, "speed", "speed, one way"),
        (StribeckShape(0.8), FRICTION, "speed", "along the runs"),
    ],
    ids=["place", "speed", "friction"],
)
def test_what_depends_on_place_or_speed_is_told(effect, side, pattern, not_of):
    found = followed({"effect": effect})
    assert found[side].excess > 0.1 and found[side].shares[pattern] > 0.5
    assert found[side].shares[not_of] < 0.5 * found[side].shares[pattern]
    if side == FRICTION:
        assert found[MECHANICS].excess < 0.1


def test_where_nothing_acts_there_is_no_excess_and_no_clue():
    found = followed({})
    assert all(abs(side.excess) < 0.1 for side in found.values())
    assert clue_of(found) is None


def test_without_a_friction_force_there_is_the_motion_alone():
    found = followed({"gear": Gear(0.3)}, silent=True)
    assert set(found) == {MOTION}
    assert found[MOTION].beat == pytest.approx(GEAR, abs=0.1) and found[MOTION].excess > 0.1


def test_values_that_a_converter_holds_come_in_moments():
    found = followed({}, lost=True)
    clue = clue_of(found)
    assert clue is not None and clue.pattern == "moments" and "a converter lost or held" in clue.look


def test_the_plainer_of_patterns_as_good_is_said_and_mechanics_first():
    near = Patterns(2.0, 9.0, 0, {"with the drive": 0.92, "speed": 0.85, "place": 0.7, "moments": 0.9}, None)
    clue = clue_of({FRICTION: dataclasses.replace(near, shares={"place": 0.9}), MECHANICS: near})
    assert clue is not None and (clue.side, clue.pattern, clue.share) == (MECHANICS, "speed", 0.85)
    assert clue.note.startswith("Closed with the measured friction force, the equation of motion lacks a ")
    assert clue.clause.endswith("a force that depends on the speed (85 % of it)")


def test_every_pattern_has_its_words():
    assert {*PATTERNS} == {*FORMS, BEAT, MOMENTS}


@pytest.mark.parametrize(
    ("side", "pattern", "said"),
    [
        (MECHANICS, "speed", (1.0, 0.0, 0.0)),
        (MECHANICS, "moments", (0.5, 0.0, 0.5)),
        (FRICTION, "moments", (0.0, 1.0, 0.0)),
        (MOTION, "speed", None),
    ],
)
def test_a_clue_says_on_which_side_the_gap_is(side, pattern, said):
    """Where the friction force was recorded; no impact is told from a value that was lost."""
    sides = Clue(side, pattern, 0.8, None).sides
    assert (sides and tuple(sides[name] for name in ("mechanics", "friction", "measurement"))) == said


@pytest.mark.parametrize(
    "found",
    [
        Patterns(0.05, 9.0, 0, {"speed": 0.9, "moments": 0.9}, None),
        Patterns(2.0, 2.0, 2, {"speed": 0.9, "moments": 0.9}, None),
        Patterns(2.0, 9.0, 0, {"speed": 0.2, "moments": 0.5}, None),
    ],
    ids=["within its noise", "by chance", "following nothing"],
)
def test_what_is_little_or_follows_nothing_is_no_clue(found):
    assert clue_of({MECHANICS: found}) is None


def test_segments_that_are_lost_come_in_moments():
    clue = clue_of({MECHANICS: Patterns(-0.1, -2.0, 9, {"moments": 1.0, "speed": 5.0}, None)})
    assert clue is not None and clue.pattern == "moments"
