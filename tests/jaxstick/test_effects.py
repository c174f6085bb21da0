"""The contract that every effect on the shelf keeps, and what the shelf refuses.

One compiled program an effect serves most of it: a run of 1600 steps, 0.2 s of slip, arrest and stick at the
finest step, with the derivative of the readings along a direction in the effect's parameters.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
import re
from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxstick.catalogue import _only_effect, catalogue
from jaxstick.compiled import QUICKLY
from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.hypothesis import Hypothesis, effects_at_null
from jaxstick.nominal import nominal
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parameter import Parameter, find, parameters, replace
from jaxstick.parts.contact import AbstractContact, LoadedContact, PaperContact, SmoothContact
from jaxstick.parts.drive import RecordedDrive, SineDrive
from jaxstick.simulate import Grid, Trajectory, march
from jaxstick.solver import step
from tests.jaxstick.fit_grid import open_grid
from tests.jaxstick.rig1987_runs import RIG, constants

ASSUMED = dataclasses.replace(constants(0.86), D=2.0)
NOMINAL = nominal(RIG, ASSUMED, SineDrive(1.5, 10.325e-3))
BEGIN = 1.678
START = Start(4.78e-3, -0.138, 6.7)
STEPS = 1600
FINEST = 1.25e-4
SIZE = {"N": 7.47, "m": 10.325e-3, "s": 1 / 4.6}
"""What a unit amounts to on this rig: level of friction, stroke, natural period."""

KEYS = sorted(catalogue())
EACH = pytest.mark.parametrize("key", KEYS)
FAMILIES = {"friction", "mechanics", "measurement"}


def size_of(unit: str) -> float:
    """What a unit amounts to on the rig: `N s/m` is friction times period over stroke."""
    whole = unit.replace("Hz", "1/s").replace("kg", "N s^2/m").replace("rad", "1")
    above, *below = whole.split("/")
    size = 1.0
    for part, sign in ((above, 1), *((each, -1) for each in below)):
        for factor in part.split():
            name, _, power = factor.partition("^")
            if name != "1":
                size *= SIZE[name] ** (sign * int(power or 1))
    return size


def shape(key: str) -> dict[str, Parameter]:
    return {
        place.path[-1]: place.parameter for place in parameters(null(key)) if place.parameter.null is None
    }


def strengths(key: str) -> dict[str, Parameter]:
    return {
        place.path[-1]: place.parameter for place in parameters(null(key)) if place.parameter.null is not None
    }


def typical(parameter: Parameter) -> float:
    assert parameter.typical is not None
    return parameter.typical * size_of(parameter.unit)


def nothing(parameter: Parameter) -> float:
    assert parameter.null is not None
    return parameter.null


def null(key: str) -> AbstractEffect:
    return effects_at_null((key,))[key]


def present(key: str) -> AbstractEffect:
    """The effect with every strength at its typical size."""
    return replace(null(key), {name: typical(kind) for name, kind in strengths(key).items()})


def touched(key: str) -> set[str]:
    """The parts of the oscillator that the effect replaces."""
    attached = null(key).attach(NOMINAL)
    names = (field.name for field in dataclasses.fields(Oscillator))
    return {name for name in names if getattr(attached, name) is not getattr(NOMINAL, name)}


def readings(oscillator: Oscillator, interval: Any) -> Any:
    """Displacement and friction as read, each in units of its own size: shape (2, STEPS + 1)."""
    run = march(oscillator, START, open_grid(BEGIN, interval, STEPS + 1, 1))
    return jnp.stack([run.displacement / SIZE["m"], run.friction / SIZE["N"]])


class Seen(NamedTuple):
    """What is read, and its derivative along a direction in the effect's parameters."""

    value: np.ndarray
    slope: np.ndarray


@functools.cache
def _program(key: str) -> Callable[..., Any]:
    effect = null(key)

    @functools.partial(jax.jit, compiler_options=QUICKLY)
    def program(values: dict[str, Any], direction: dict[str, Any], interval: Any) -> Any:
        def read(values: dict[str, Any]) -> Any:
            return readings(replace(effect, values).attach(NOMINAL), interval)

        return jax.jvp(read, (values,), (direction,))

    return program


def seen(
    key: str, values: dict[str, float], direction: dict[str, float] | None = None, interval: float = FINEST
) -> Seen:
    """The readings with these values, all else at default, and their slope along the direction."""
    effect = null(key)
    own = {place.path[-1]: float(place.of(effect)) for place in parameters(effect)}
    at = {name: jnp.asarray(values.get(name, value)) for name, value in own.items()}
    along = {name: jnp.asarray((direction or {}).get(name, 0.0)) for name in own}
    return Seen(*map(np.asarray, _program(key)(at, along, jnp.asarray(interval))))


@functools.cache
def without(interval: float = FINEST) -> np.ndarray:
    return np.asarray(jax.jit(readings)(NOMINAL, jnp.asarray(interval)))


def norm(signal: np.ndarray) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def test_the_run_slips_sticks_and_breaks_away():
    """Or the contract would not show what an effect does in each phase."""
    run = jax.jit(march)(NOMINAL, START, Grid(BEGIN, FINEST, STEPS + 1, 1))
    static = SIZE["N"]
    speed, force = np.abs(np.asarray(run.v)), np.abs(np.asarray(run.force))
    assert np.mean((speed > 0.02) & (force > 0.8 * static)) > 0.2
    assert np.mean(force < 0.6 * static) > 0.05
    assert np.ptp(np.sign(run.force)) == 2


@EACH
def test_nothing_changes_at_null(key):
    assert np.max(np.abs(seen(key, {}).value - without())) < 1e-12


@EACH
def test_the_derivative_at_null_is_that_of_a_small_strength(key):
    """Each strength by itself, from inside its bounds where it is bounded at null."""
    at_null = seen(key, {}).value
    for name, kind in strengths(key).items():
        size = typical(kind)
        slope = seen(key, {}, {name: size}).slope
        assert np.all(np.isfinite(slope))
        assert norm(slope) > 1e-4, "typical of its size, it is not even seen"
        share = 1e-6
        ahead = seen(key, {name: nothing(kind) + share * size}).value
        if kind.lower < nothing(kind):
            difference = (ahead - seen(key, {name: nothing(kind) - share * size}).value) / (2 * share)
        else:
            difference = (ahead - at_null) / share
        assert norm(difference - slope) < 1e-2 * norm(slope)


@EACH
def test_every_parameter_matters_where_the_effect_is_present(key):
    values = {name: typical(kind) for name, kind in strengths(key).items()}
    there = seen(key, values).value
    assert norm(there - without()) > 1e-4
    for name in values:
        assert norm(there - seen(key, {**values, name: nothing(strengths(key)[name])}).value) > 1e-5
    absent = {n: typical(k) for n, k in shape(key).items() if not float(find(null(key), n).of(null(key)))}
    for name in shape(key):
        slope = seen(key, {**values, **absent}, {name: 1.0}).slope
        assert np.all(np.isfinite(slope))
        assert norm(slope) > 0


@EACH
def test_what_an_effect_does_is_not_made_by_the_step(key):
    """The change that it makes converges as the step is halved twice."""
    values = {name: typical(kind) for name, kind in strengths(key).items()}
    coarse, middle, fine = (
        (seen(key, values, interval=FINEST * ratio).value - without(FINEST * ratio))[
            :, : STEPS * 4 // (4 * ratio) + 1 : 4 // ratio
        ]
        for ratio in (4, 2, 1)
    )
    common = STEPS // 4 + 1
    coarse, middle, fine = coarse[:, :common], middle[:, :common], fine[:, :common]
    first, second = norm(coarse - middle), norm(middle - fine)
    assert second < 0.1 * norm(fine)
    assert second < 0.75 * first or second < 0.02 * norm(fine)


@EACH
def test_parameters_say_what_they_are(key):
    effect = null(key)
    places = list(parameters(effect))
    assert places and places[0].parameter.null is not None, "an effect begins with its strength"
    for place in places:
        kind, value = place.parameter, float(place.of(effect))
        assert kind.unit and kind.meaning
        assert size_of(kind.unit) > 0
        assert not math.isnan(kind.lower) and kind.lower < kind.upper
        assert kind.lower <= value <= kind.upper
        if kind.null is None:
            assert kind.typical is None or kind.lower <= typical(kind) <= kind.upper
            share = kind.unit == "1" and kind.lower == 0 and math.isfinite(kind.upper) and kind.typical
            assert value != 0 or share or kind.signed, (
                "a shape that is nothing by default says nothing where it begins"
            )
        else:
            assert value == kind.null and kind.typical is not None and kind.typical > 0
            assert kind.lower <= kind.null < typical(kind) <= kind.upper


@EACH
def test_the_card_is_written(key):
    card = catalogue()[key].card
    assert card.family in FAMILIES
    for name, words in (("title", 2), ("symptom", 10), ("explanation", 15), ("remedy", 8), ("source", 3)):
        text = getattr(card, name)
        assert len(text.split()) >= words, name
        assert text == text.strip() and not re.search(r"  |\bTODO\b", text), name
        assert text[0].isupper() or text[0] == "d", name
        assert name == "title" or text.endswith("."), name
    assert len({getattr(card, field.name) for field in dataclasses.fields(card)}) == 6


def test_no_two_cards_are_alike():
    for name in ("title", "symptom", "explanation"):
        texts = [getattr(effect.card, name) for effect in catalogue().values()]
        assert len(set(texts)) == len(texts)


def test_effects_on_different_parts_commute():
    """Whichever is attached first, the oscillator is the same, part by part and number by number."""
    parts = {key: touched(key) for key in KEYS}
    assert all(parts.values())
    for one, other in itertools.combinations(KEYS, 2):
        if parts[one] & parts[other]:
            continue
        a, b = present(one), present(other)
        assert eqx.tree_equal(a.attach(b.attach(NOMINAL)), b.attach(a.attach(NOMINAL))), (one, other)


def _siblings() -> list[tuple[str, str]]:
    """Each effect with the two that follow it among those on the same part."""
    pairs = set()
    for part in {name for key in KEYS for name in touched(key)}:
        keys = [key for key in KEYS if part in touched(key)]
        for i, key in enumerate(keys):
            pairs |= {tuple(sorted((key, keys[(i + gap) % len(keys)]))) for gap in (1, 2)}
    return sorted((a, b) for a, b in pairs if a != b)


def _stepped(oscillator: Oscillator) -> np.ndarray:
    """Displacement, velocity, force and readings after three steps of 1 ms, without compiling."""
    h = 1e-3
    state = jax.tree.map(jnp.asarray, oscillator.initial(BEGIN, START))
    acceleration = oscillator.acceleration(BEGIN, state)
    for number in range(3):
        before, after = (oscillator.drive.at(BEGIN + h * (number + i)) for i in (0, 1))
        t = BEGIN + h * (number + 1)
        state, acceleration = step(oscillator, t, h, before, after, state, acceleration)
    motion = oscillator.motion(t, after, state.x, state.v, acceleration)
    reading = oscillator.instrument.read(state.instrument, motion, state.friction)
    return np.array([state.x, state.v, state.friction, reading.displacement, reading.friction])


@functools.cache
def _alone(key: str) -> np.ndarray:
    return _stepped(present(key).attach(NOMINAL))


@pytest.mark.parametrize(("one", "other"), _siblings())
def test_effects_on_the_same_part_attach_in_either_order(one, other):
    for first, second in ((one, other), (other, one)):
        begun = present(first).attach(NOMINAL)
        both = _stepped(present(second).attach(begun))
        assert np.all(np.isfinite(both))
        zero = dict.fromkeys(strengths(second), 0.0)
        silent = _stepped(replace(present(second), zero).attach(begun))
        np.testing.assert_allclose(silent, _alone(first), rtol=1e-11, atol=1e-15)


def shelf(keys: list[str], oscillator: Oscillator, values: dict[str, dict[str, Any]]) -> Oscillator:
    """The oscillator with these effects attached in this order."""
    effects = effects_at_null(tuple(keys))
    return Hypothesis(
        oscillator, {key: replace(effects[key], values.get(key, {})) for key in keys}
    ).oscillator()


TIMES = 2e-3 * np.arange(200)
BASE = 10.325e-3 * np.sin(2 * np.pi * 1.5 * TIMES)
PUSH = 12 * np.sin(2 * np.pi * 2.0 * TIMES)


def rigs(contact: type[AbstractContact]) -> Oscillator:
    """Two lanes: the rig of 1987 driven by a recorded base, and a free mass pushed by a recorded force."""
    sprung = dataclasses.replace(
        NOMINAL, drive=RecordedDrive.through(0.0, 2e-3, BASE), contact=contact(NOMINAL.contact.k1)
    )
    free = replace(
        dataclasses.replace(sprung, drive=RecordedDrive.through(0.0, 2e-3, 0 * BASE, PUSH)),
        {"stiffness": 0.0, "drive_stiffness": 0.0},
    )
    return jax.tree.map(
        lambda *leaves: jnp.stack([jnp.asarray(leaf, float) for leaf in leaves]), sprung, free
    )


@pytest.mark.parametrize("contact", [LoadedContact, PaperContact, SmoothContact])
def test_the_whole_shelf_at_null_is_the_nominal_model(contact):
    """Every effect at once, lane by lane, forward on one contact and backward on the others; and with the
    loaded contact a derivative along all strengths together."""
    keys = KEYS if contact is LoadedContact else KEYS[::-1]
    zeros = {key: {name: jnp.asarray(0.0) for name in strengths(key)} for key in keys}
    along = {key: {name: jnp.asarray(typical(kind)) for name, kind in strengths(key).items()} for key in keys}
    starts = Start(jnp.array([1e-3, 0.0]), jnp.array([0.05, 0.0]), jnp.array([-6.0, 1.0]))
    starts = jax.tree.map(lambda part: jnp.broadcast_to(jnp.asarray(part, float), (2,)), starts)

    def travel(oscillator: Oscillator, start: Start) -> Trajectory:
        return march(oscillator, start, open_grid(0.0, 2e-3, 150, 4))

    def whole(oscillator: Oscillator, start: Start, values: dict[str, dict[str, Any]]) -> Trajectory:
        return travel(shelf(keys, oscillator, values), start)

    @functools.partial(jax.jit, compiler_options=QUICKLY)
    def both(oscillators: Oscillator, starts: Start) -> Any:
        bare = jax.vmap(travel)(oscillators, starts)
        if contact is not LoadedContact:
            return bare, jax.vmap(lambda o, s: whole(o, s, zeros))(oscillators, starts), ()
        directed = jax.vmap(lambda o, s: jax.jvp(lambda v: whole(o, s, v), (zeros,), (along,)))
        return bare, *directed(oscillators, starts)

    bare, clothed, slope = both(rigs(contact), starts)
    for name in Trajectory._fields:
        expected, found = np.asarray(getattr(bare, name)), np.asarray(getattr(clothed, name))
        assert np.max(np.abs(found - expected)) < 1e-12 * np.max(np.abs(expected)), name
    assert all(np.all(np.isfinite(channel)) for channel in slope)


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
    with pytest.raises(UserError, match=r"'xyz'; there are .*asymmetric_friction, .*constant_force"):
        effects_at_null(("xyz",))
    assert effects_at_null(()) == {}
