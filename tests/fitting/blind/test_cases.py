"""Cases: the same from the same seed, of the strength that was drawn, read by the program's own loader."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from fitting.blind.case import assignments, draw_case, true_channels
from fitting.blind.folder import write_case
from fitting.blind.gap import gap
from fitting.blind.kinds import KINDS, SHARES, TIERS
from fitting.blind.menu import ALIASES, LISTED
from fitting.blind.recipe import Chosen, recipe_from
from fitting.blind.recorder import recorded
from fitting.blind.seeds import stream
from jaxstick.check import describe
from jaxstick.record import load_dataset
from tests.fitting.blind.small import SETTINGS, tiny_case, tiny_rig


def test_a_seed_makes_the_same_case_again():
    first, again = (tiny_case("pair", "force_gain", "cubic_stiffness", number=4) for _ in range(2))
    assert first[1] == again[1]
    other = draw_case(
        replace(SETTINGS, family="judging"), 4, assignments(1, SETTINGS, {"none": 1.0}, ("A",))[0]
    )
    assert other[0].physics.mass != first[0].physics.mass


def test_families_of_seeds_share_nothing():
    numbers = [stream(family, 3, "case").random() for family in ("development", "calibration", "judging")]
    assert len(set(numbers)) == 3
    with pytest.raises(ValueError, match="development"):
        stream("training", 3)


def test_assignments_are_even():
    found = assignments(920, SETTINGS, SHARES, TIERS)
    assert Counter(one.kind for one in found) == {"single": 400, "none": 300, "pair": 120, "unlisted": 100}
    singles = Counter(one.keys[0] for one in found if one.kind == "single")
    assert set(singles) == set(LISTED)
    assert max(singles.values()) - min(singles.values()) <= 1
    for one in found:
        if one.kind == "pair":
            assert len(set(one.keys)) == 2
            assert not any(set(one.keys) <= group for group in ALIASES)
    assert {one.tier for one in found} == set(TIERS)


def test_a_gap_vanishes_without_an_effect_and_where_the_constants_take_it_over():
    recipe, scales = tiny_rig()
    assert gap(recipe, (), scales).fixed_rig < 1e-9
    gain = Chosen(key="force_gain", version="A", strength=0.02)
    opened = gap(replace(recipe, effects=(gain,)), (gain,), scales)
    assert opened.fixed_rig > 0.2
    assert opened.free_rig < 0.25 * opened.fixed_rig


@pytest.mark.parametrize("key", ["force_offset", "cubic_stiffness", "position_dependent_friction"])
def test_the_gap_is_the_one_that_was_drawn(key):
    _, answer = tiny_case("single", key)
    effect = answer["effects"][key]
    assert 3.0 <= effect["wanted"] <= 30.0
    assert effect["wanted"] / 1.5 < effect["gap_ratio"] < effect["wanted"] * 1.5


def test_weak_effects_lie_about_the_detection_limit():
    weak = replace(SETTINGS, strength="weak")
    assignment = assignments(1, SETTINGS, {"single": 1.0}, ("A",))[0]
    _, answer = draw_case(weak, 1, replace(assignment, keys=("force_offset",)))
    assert 0.3 < answer["effects"]["force_offset"]["limit_ratio"] < 12.0


@pytest.mark.parametrize("tier", TIERS)
def test_a_record_is_the_truth_and_its_noise(tier):
    recipe, answer = tiny_case("single", "spring_relaxation", tier=tier, number=7)
    answer = json.loads(json.dumps(answer))
    assert recipe_from(answer["recipe"]) == recipe
    for index, truth in enumerate(true_channels(answer)):
        record = recorded(recipe, index)
        for name, channel in (("displacement", recipe.displacement), ("friction", recipe.friction)):
            error = record[name] - truth[name]
            assert 0.6 * channel.deviation < np.std(error) < 1.6 * channel.deviation
    with_effects, without = (
        true_channels(answer, with_effects=effects)[0]["displacement"] for effects in (True, False)
    )
    assert np.abs(with_effects - without).max() > recipe.displacement.deviation


@pytest.mark.parametrize("kind", KINDS)
def test_a_case_is_a_data_set(tmp_path, kind):
    keys = {"single": ("base_gain",), "pair": ("end_stop", "force_delay"), "unlisted": ("bit_errors",)}
    for number, tier in enumerate(TIERS):
        recipe, _ = tiny_case(kind, *keys.get(kind, ()), tier=tier, number=number)
        folder = tmp_path / f"case-{number}"
        write_case(recipe, folder)
        dataset = load_dataset(folder)
        assert len(dataset.runs) == 2
        assert dataset.rig.stiffness == pytest.approx(recipe.physics.stiffness, rel=1e-6)
        assert describe(dataset).runs[0].samples == recipe.runs[0].samples
        for index, run in enumerate(dataset.runs):
            expected = recorded(recipe, index)
            assert (
                np.abs(run.displacement - expected["displacement"]).max() < recipe.displacement.quantum / 10
            )


def test_without_a_base_channel_the_stated_drive_begins_at_phase_zero():
    for number in range(30):
        recipe, _ = tiny_case("single", "base_delay", number=number)
        if recipe.base is None:
            late = recipe.effects[0].strength
            for plan in recipe.runs:
                assert plan.phase == pytest.approx(2 * np.pi * plan.frequency * late)
            return
    raise AssertionError("every rig recorded its base")
