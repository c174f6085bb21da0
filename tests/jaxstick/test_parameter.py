"""Parameters of trees of modules: listed, found by name, replaced."""

from __future__ import annotations

import pytest

from jaxstick.effects.asymmetric_friction import AsymmetricFriction
from jaxstick.effects.constant_force import ConstantForce
from jaxstick.hypothesis import Hypothesis
from jaxstick.nominal import nominal
from jaxstick.parameter import find, parameters, replace
from jaxstick.parts.drive import SineDrive
from tests.jaxstick.rig1987_runs import RIG, constants

HYPOTHESIS = Hypothesis(
    nominal(RIG, constants(0.86), SineDrive(1.5, 0.01)),
    {"first": ConstantForce(force=0.3), "second": AsymmetricFriction(dry=0.1), "third": ConstantForce()},
)


def test_every_parameter_is_listed_once_with_its_place_in_dictionaries_too():
    paths = [".".join(place.path) for place in parameters(HYPOTHESIS)]
    assert len(set(paths)) == len(paths)
    assert set(paths) == {
        *(f"nominal.rig.{n}" for n in ("mass", "stiffness", "drive_stiffness", "damping", "drive_damping")),
        *(f"nominal.drive.{n}" for n in ("frequency", "base_amplitude", "force_amplitude", "phase")),
        *(f"nominal.friction.{n}" for n in "ABCD"),
        "nominal.contact.k1",
        *(
            "effects.first.force",
            "effects.second.dry",
            "effects.second.viscous",
            "effects.second.steady",
            "effects.third.force",
        ),
    }
    units = {place.path[-1]: place.parameter.unit for place in parameters(HYPOTHESIS)}
    assert (units["mass"], units["B"], units["force"], units["dry"]) == ("kg", "s/m", "N", "1")


def test_a_name_is_found_wherever_it_is_alone():
    assert find(HYPOTHESIS, "mass").of(HYPOTHESIS) == RIG.mass
    assert find(HYPOTHESIS, "friction.A").path == ("nominal", "friction", "A")
    assert find(HYPOTHESIS, "first.force").of(HYPOTHESIS) == 0.3
    assert find(HYPOTHESIS, "effects.third.force").of(HYPOTHESIS) == 0.0


@pytest.mark.parametrize(
    ("name", "count"), [("force", 2), ("nothing", 0), ("riction.A", 0), ("contact.A", 0), ("", 0)]
)
def test_an_ambiguous_or_unknown_name_is_a_key_error_that_says_what_there_is(name, count):
    with pytest.raises(KeyError, match=rf"{count} parameters are called '{name}'.*nominal\.friction\.A"):
        find(HYPOTHESIS, name)


def test_replace_sets_the_named_ones_and_nothing_else():
    new = replace(HYPOTHESIS, {"mass": 3.0, "first.force": -1.0, "second.dry": 0.2})
    values = {place.path: place.of(new) for place in parameters(new)}
    old = {place.path: place.of(HYPOTHESIS) for place in parameters(HYPOTHESIS)}
    changed = {path: value for path, value in values.items() if value != old[path]}
    assert changed == {
        ("nominal", "rig", "mass"): 3.0,
        ("effects", "first", "force"): -1.0,
        ("effects", "second", "dry"): 0.2,
    }
    assert HYPOTHESIS.nominal.rig.mass == RIG.mass  # pyright: ignore[reportAttributeAccessIssue]
    assert replace(HYPOTHESIS, {}) is HYPOTHESIS
    with pytest.raises(KeyError):
        replace(HYPOTHESIS, {"force": 1.0})
