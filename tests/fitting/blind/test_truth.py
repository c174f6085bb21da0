"""The truth generator against the event-driven reference, and every effect's null."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from fitting.blind.formulation import Formulation
from fitting.blind.friction_effects import FRICTION
from fitting.blind.further_forms import FURTHER
from fitting.blind.march import march, start_state
from fitting.blind.measurement_effects import MEASUREMENT
from fitting.blind.mechanics_effects import MECHANICS
from fitting.blind.menu import FAMILIES, LISTED, STRANGE, formulation, other_versions
from fitting.blind.physics import Elements, Physics
from fitting.blind.recipe import Chosen, Recipe, recipe_from
from fitting.blind.scales import Scales
from fitting.blind.truth import noise_free
from fitting.blind.unlisted_effects import UNLISTED
from jaxstick.catalogue import catalogue
from jaxstick.parameter import parameters
from tests.fitting.blind.small import tiny_rig
from tests.reference import loaded, rig1987

PERIOD = 1.0 / rig1987.NATURAL_FREQUENCY
EVERY = (*FRICTION, *MECHANICS, *MEASUREMENT, *FURTHER, *UNLISTED)


@pytest.mark.parametrize(
    ("ratio", "viscous", "against"),
    [(0.326, 0.002, "ground"), (0.109, 4.0, "ground"), (0.6, 2.0, "ground"), (0.326, 1.0, "base")],
)
def test_it_follows_the_event_driven_reference(ratio, viscous, against):
    share = 1.0 if against == "ground" else 0.6
    rig, drive = rig1987.rig(), rig1987.drive(ratio)
    rig = replace(
        rig,
        D=viscous,
        drive_stiffness=share * rig.stiffness,
        drive_damping=1.0,
        friction_against=against,
    )
    count, steps = 300, 40
    reference = loaded.simulate(rig, drive, np.arange(count + 1) * PERIOD / 100, x0=1e-3)
    physics = Physics(
        mass=rig.mass,
        stiffness=rig.stiffness,
        drive_stiffness=share * rig.stiffness,
        damping=rig.damping,
        drive_damping=1.0,
        against_base=float(against == "base"),
        amplitude=drive.base_amplitude,
        omega=2.0 * np.pi * drive.frequency,
        A=rig.A,
        B=rig.B,
        C=rig.C,
        D=viscous,
        k1=rig.k1,
    ).record()
    out = np.empty((count, 5))
    state = start_state(physics, 1e-3, 0.0, 0.0)
    interval = PERIOD / 100 / steps
    march(physics, Elements().array(), np.ones(1), 0.0, 1.0, state, 0.0, interval, steps, count, out, True)
    stroke = np.ptp(reference.x) / 2
    assert np.abs(out[:, 0] - reference.x[1:]).max() < 1e-5 * stroke
    assert np.sqrt(np.mean((out[:, 2] - reference.F[1:]) ** 2)) < 1e-4 * rig.static_friction


class Tiny(NamedTuple):
    """A rig without effects, its scales, and the channels of one of its runs."""

    recipe: Recipe
    scales: Scales
    channels: np.ndarray


def change(rig: Tiny, effect: Formulation, share: float) -> np.ndarray:
    """What a share of the most that there may be of an effect changes in the channels of the run, each in
    units of its own size."""
    recipe, scales, still = rig
    chosen = Chosen(
        key=effect.key,
        version=effect.version,
        strength=share * effect.most(scales),
        shape=effect.shape(scales, np.random.default_rng(5)),
    )
    size = np.array([scales.stroke, scales.force, scales.base])[:, None]
    return (channels(replace(recipe, effects=(chosen,))) - still) / size


def channels(recipe: Recipe) -> np.ndarray:
    """Displacement, friction force and base of the first run."""
    seen = noise_free(recipe, 0)
    return np.stack([seen.displacement, seen.friction, seen.base])


@pytest.fixture(scope="module")
def rig():
    recipe, scales = tiny_rig()
    return Tiny(recipe, scales, channels(recipe))


@pytest.mark.parametrize("effect", EVERY, ids=lambda effect: f"{effect.key}-{effect.version}")
def test_an_effect_acts_and_fades_with_its_strength(rig, effect):
    strong, faint = (np.abs(change(rig, effect, share)) for share in (1.0, 1e-6))
    assert np.isfinite(strong).all()
    acts = strong.max(axis=1) > 1e-6
    assert acts.any()
    assert faint.mean() < 0.02 * strong.mean()
    only = {"force": [False, True, False], "displacement": [True, False, False], "base": [False, False, True]}
    if FAMILIES.get(effect.key) == "measurement":
        channel = "force" if effect.key == "mains_hum" else effect.key.partition("_")[0]
        assert acts.tolist() == only[channel]


def test_every_listed_effect_has_both_forms():
    assert len(LISTED) == 38
    assert len(STRANGE) >= 8
    assert set(LISTED) <= set(catalogue())
    for key in LISTED:
        assert formulation(key, "A").version == "A"
        assert formulation(key, "B").version == "B"
    third = {one.key: one for one in FURTHER}
    assert len(third) == len(FURTHER)
    for key in LISTED:
        assert other_versions(key) == (("B", "B2") if key in third else ("B",))
        assert key not in third or formulation(key, "B2") is third[key]


@pytest.mark.parametrize("effect", FURTHER, ids=lambda effect: effect.key)
def test_a_third_form_is_neither_of_the_others(rig, effect):
    """Nor a multiple of them: what it does goes otherwise through the records."""
    third, *others = (change(rig, formulation(effect.key, v), 0.3).ravel() for v in ("B2", "A", "B"))
    for other in others:
        alike = abs(third @ other) / np.sqrt((third @ third) * (other @ other))
        assert alike < 1 - 1e-6


@pytest.mark.parametrize("key", LISTED)
def test_answers_name_the_parameters_as_the_catalogue_does(key):
    effect, (_, scales) = formulation(key, "A"), tiny_rig()
    named = effect.described(effect.typical(scales), effect.shape(scales, np.random.default_rng(1)))
    known = {place.path[-1]: place.parameter for place in parameters(catalogue()[key]())}  # pyright: ignore[reportCallIssue]
    assert set(named) <= set(known)
    for name, entry in named.items():
        assert entry["unit"] == known[name].unit
        assert known[name].lower <= float(entry["value"]) <= known[name].upper


def test_a_recipe_survives_being_written_down():
    recipe, _ = tiny_rig(tier="C")
    assert recipe_from(recipe.plain()) == recipe
