"""The contract that every effect on the shelf keeps, and what the shelf refuses."""

from __future__ import annotations

import dataclasses
import math
from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.catalogue import _only_effect, catalogue
from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.hypothesis import Hypothesis, effects_at_null
from jaxstick.nominal import nominal
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parameter import find, parameters, replace
from jaxstick.parts.drive import SineDrive
from jaxstick.simulate import Grid, Trajectory, march
from tests.jaxstick.rig1987_runs import RIG, constants

GRID = Grid(0.0, 2e-3, 400, 4)
ASSUMED = dataclasses.replace(constants(0.86), D=2.0)
DRIVE = SineDrive(1.5, 10.325e-3)
NOMINAL = nominal(RIG, ASSUMED, DRIVE)
AWAY = 0.1
"""A value away from null that is within the bounds of every strength and large enough to be seen."""

KEYS = sorted(catalogue())
EACH = pytest.mark.parametrize("key", KEYS)


@jax.jit
def travelled(oscillator: Oscillator) -> Trajectory:
    return march(oscillator, Start(), GRID)


def trajectory(hypothesis: Hypothesis) -> Trajectory:
    return travelled(hypothesis.oscillator())


def null(key: str) -> AbstractEffect:
    return effects_at_null((key,))[key]


def names(key: str) -> list[str]:
    return [place.path[-1] for place in parameters(null(key))]


def at(key: str, value: float) -> AbstractEffect:
    """The effect with every parameter at this value."""
    return replace(null(key), dict.fromkeys(names(key), value))


def off(one: Trajectory, other: Trajectory) -> float:
    """The largest difference of two trajectories, each channel in units of its own size."""
    return max(
        float(np.max(np.abs(np.asarray(a) - np.asarray(b))) / np.max(np.abs(np.asarray(b))))
        for a, b in zip(one, other, strict=True)
    )


@EACH
def test_nothing_changes_at_null(key):
    assert (
        off(trajectory(Hypothesis(NOMINAL, effects_at_null((key,)))), trajectory(Hypothesis(NOMINAL))) < 1e-12
    )


@EACH
def test_every_parameter_changes_something_away_from_null(key):
    without = trajectory(Hypothesis(NOMINAL))
    for name in names(key):
        effect = replace(at(key, AWAY), {name: find(null(key), name).parameter.null})
        assert off(trajectory(Hypothesis(NOMINAL, {key: at(key, AWAY)})), without) > 1e-4
        assert (
            off(
                trajectory(Hypothesis(NOMINAL, {key: at(key, AWAY)})),
                trajectory(Hypothesis(NOMINAL, {key: effect})),
            )
            > 1e-5
        )


@pytest.mark.parametrize(("one", "other"), [(a, b) for i, a in enumerate(KEYS) for b in KEYS[i + 1 :]])
def test_two_effects_attach_in_either_order(one, other):
    pair = {one: at(one, AWAY), other: at(other, -AWAY)}
    forward = trajectory(Hypothesis(NOMINAL, pair))
    backward = pair[one].attach(pair[other].attach(NOMINAL))
    assert off(travelled(backward), forward) < 1e-9
    assert off(forward, trajectory(Hypothesis(NOMINAL, {one: pair[one]}))) > 1e-4
    assert off(forward, trajectory(Hypothesis(NOMINAL, {other: pair[other]}))) > 1e-4


@EACH
def test_parameters_say_what_they_are(key):
    effect = null(key)
    places = list(parameters(effect))
    assert places, "an effect needs a strength"
    for place in places:
        kind = place.parameter
        assert kind.unit and kind.meaning
        assert not math.isnan(kind.lower) and kind.lower < kind.upper
        assert kind.null is not None and kind.lower < kind.null < kind.upper
        assert place.of(effect) == kind.null
        assert kind.lower <= AWAY <= kind.upper


@EACH
def test_the_card_is_written(key):
    card = catalogue()[key].card
    for field in dataclasses.fields(card):
        assert len(getattr(card, field.name).split()) >= (1 if field.name == "family" else 2), field.name
    assert len({getattr(card, field.name) for field in dataclasses.fields(card)}) == 6


@EACH
def test_the_gradient_at_null_is_finite_and_sees_the_strength(key):
    effect = null(key)
    weight = jnp.asarray(np.random.default_rng(1).standard_normal(GRID.samples))

    @jax.jit
    def probe(values: dict[str, Any]) -> Any:
        motion = march(Hypothesis(NOMINAL, {key: replace(effect, values)}).oscillator(), Start(), GRID)
        return weight @ motion.displacement / 1e-2 + weight @ motion.friction

    slopes = jax.jacfwd(probe)(dict.fromkeys(names(key), jnp.asarray(0.0)))
    assert all(np.isfinite(slope) for slope in slopes.values())
    assert abs(slopes[names(key)[0]]) > 1e-6


def made_up(*members: type) -> ModuleType:
    module = ModuleType("made_up")
    for member in members:
        own = type(member.__name__, (member,), {"__module__": "made_up"})
        setattr(module, own.__name__, own)
    return module


def test_a_file_holds_exactly_one_effect():
    first, second = (catalogue()[key] for key in KEYS[:2])
    assert issubclass(_only_effect(made_up(first)), first)
    with pytest.raises(TypeError, match=r"made_up must define exactly one effect, found 2"):
        _only_effect(made_up(first, second))
    with pytest.raises(TypeError, match=r"made_up must define exactly one effect, found 0"):
        _only_effect(made_up(dict))
    imported = made_up(first)
    imported.__dict__["Imported"] = second
    assert issubclass(_only_effect(imported), first), "an imported effect is not the file's own"


def test_an_unknown_key_is_refused_with_the_nearest():
    with pytest.raises(UserError, match=r"'constant_fource'; did you mean 'constant_force'\?"):
        effects_at_null(("constant_fource",))
    with pytest.raises(UserError, match=r"'xyz'; there are .*asymmetric_friction, constant_force"):
        effects_at_null(("xyz",))
    assert effects_at_null(()) == {}
