"""One sealed case: what is to happen in it, its recipe, and the answer that is withheld."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fitting.blind.gap import detection_limit, gap
from fitting.blind.menu import (
    FAMILIES,
    LISTED,
    STRANGE,
    aliases,
    formulation,
    may_be_paired,
    other_versions,
)
from fitting.blind.recipe import Recipe, recipe_from
from fitting.blind.recorder import sampled
from fitting.blind.rigs import Size, draw_rig
from fitting.blind.scales import Scales
from fitting.blind.seeds import stream
from fitting.blind.statement import with_statement
from fitting.blind.strength import Sized, relevant, size_effect
from fitting.blind.truth import driven, noise_free, seen_drive

ATTEMPTS = 6
FAINT = 0.3
"""An effect that its largest sensible strength leaves below this share of the gap drawn gets another rig."""


@dataclass(frozen=True)
class Assignment:
    """What a case is to hold: its kind, its tier, and the effects' keys."""

    kind: str
    tier: str
    keys: tuple[str, ...]


@dataclass(frozen=True)
class Settings:
    """What all cases of a set have in common: where their random numbers come from, how much is recorded,
    how strong effects are ("strong" or "weak"), and how strong faults put on given records, where not so:
    from how many to how many times the noise of a channel."""

    family: str
    seed: int
    size: Size
    strength: str = "strong"
    spike_times: tuple[float, float] | None = None


def assignments(
    count: int, settings: Settings, kinds: Mapping[str, float], tiers: tuple[str, ...]
) -> list[Assignment]:
    """What each of `count` cases holds, in random order.

    Kinds come in the proportions given, effects and tiers equally often, as far as the count allows.
    """
    random = stream(settings.family, settings.seed, "assignments")
    names = _proportioned(count, kinds)
    listed, strange = _rounds(LISTED, random), _rounds(STRANGE, random)
    tier = {kind: _rounds(tiers, random) for kind in kinds}
    found = []
    for kind in names:
        keys: tuple[str, ...] = ()
        if kind == "single":
            keys = (next(listed),)
        elif kind == "unlisted":
            keys = (next(strange),)
        elif kind == "pair":
            first = next(listed)
            partners = [key for key in LISTED if may_be_paired(first, key)]
            keys = (first, partners[random.integers(len(partners))])
        found.append(Assignment(kind, next(tier[kind]), keys))
    return [found[i] for i in random.permutation(count)]


def _proportioned(count: int, kinds: Mapping[str, float]) -> list[str]:
    """Each kind in its share of `count`, by largest remainders."""
    total = sum(kinds.values())
    exact = {kind: count * share / total for kind, share in kinds.items()}
    whole = {kind: int(number) for kind, number in exact.items()}
    rest = sorted(kinds, key=lambda kind: whole[kind] - exact[kind])
    for kind in rest[: count - sum(whole.values())]:
        whole[kind] += 1
    return [kind for kind, number in whole.items() for _ in range(number)]


def _rounds(items: tuple[str, ...], random: np.random.Generator):
    """The items in random order, again and again."""
    while True:
        yield from (items[i] for i in random.permutation(len(items)))


def draw_case(settings: Settings, number: int, assignment: Assignment) -> tuple[Recipe, dict[str, Any]]:
    """The recipe of case `number` (from 1), and its answer.

    Where the rig that was drawn leaves an effect far weaker than wanted, another is drawn, a few times.
    """
    best: tuple[float, Recipe, Scales, list[Sized]] | None = None
    for attempt in range(ATTEMPTS):
        random = stream(settings.family, settings.seed, "case", number, attempt)
        recipe, scales = draw_rig(random, assignment.tier, settings.size)
        recipe = with_statement(recipe, random)
        sized = [
            size_effect(recipe, scales, formulation(key, version), settings.strength, random)
            for key, version in zip(assignment.keys, _versions(assignment, random), strict=True)
        ]
        reached = min((one.reached / one.wanted for one in sized), default=1.0)
        if best is None or reached > best[0]:
            best = reached, recipe, scales, sized
        if reached > FAINT:
            break
    assert best is not None
    _, recipe, scales, sized = best
    recipe = settled_drive(replace(recipe, effects=tuple(one.chosen for one in sized)))
    return recipe, _answer(settings, assignment, recipe, scales, sized)


def _versions(assignment: Assignment, random: np.random.Generator) -> list[str]:
    if assignment.kind == "unlisted":
        return ["unlisted"]
    if assignment.tier == "C":
        return [str(random.choice(["A", "B"])) for _ in assignment.keys]
    if assignment.tier == "B":
        return [str(random.choice(other_versions(key))) for key in assignment.keys]
    return [assignment.tier for _ in assignment.keys]


def settled_drive(recipe: Recipe) -> Recipe:
    """Where the base is not recorded, the drive that is stated has phase 0 at the first sample."""
    if recipe.base is not None:
        return recipe
    runs = []
    for index, plan in enumerate(recipe.runs):
        seen = seen_drive(recipe, index, driven(recipe, plan))
        runs.append(replace(plan, phase=plan.phase - seen.phase))
    return replace(recipe, runs=tuple(runs))


def _answer(
    settings: Settings, assignment: Assignment, recipe: Recipe, scales: Scales, sized: list[Sized]
) -> dict[str, Any]:
    p = recipe.physics
    truth = {"none": ["none"], "unlisted": ["unlisted"]}.get(assignment.kind, list(assignment.keys))
    whole = gap(recipe, recipe.effects, scales) if len(sized) > 1 else sized[0].gap if sized else None
    return {
        "kind": assignment.kind,
        "tier": assignment.tier,
        "truth": truth,
        "families": [FAMILIES[key] for key in assignment.keys if key in FAMILIES],
        "aliases": {key: list(aliases(key)) for key in assignment.keys if key in FAMILIES},
        "unlisted": list(assignment.keys) if assignment.kind == "unlisted" else [],
        "strength": settings.strength,
        "effects": {
            one.chosen.key: {
                "version": one.chosen.version,
                "parameters": formulation(one.chosen.key, one.chosen.version).described(
                    one.chosen.strength, one.chosen.shape
                ),
                "gap_ratio": one.reached,
                "limit_ratio": one.reached / detection_limit(recipe),
                "gap_fixed_rig": one.gap.fixed_rig,
                "gap_free_rig": one.gap.free_rig,
                "wanted": one.wanted,
            }
            for one in sized
        },
        "gap_ratio": 0.0 if whole is None else max(relevant(key, whole) for key in assignment.keys),
        "constants": {name: getattr(p, name) for name in ("A", "B", "C", "D", "k1")},
        "rig": {
            "mass": p.mass,
            "stiffness": p.stiffness,
            "drive_stiffness": p.drive_stiffness,
            "damping": p.damping,
            "drive_damping": p.drive_damping,
        },
        "recipe": recipe.plain(),
    }


def true_channels(answer: Mapping[str, Any], with_effects: bool = True) -> list[dict[str, np.ndarray]]:
    """The noise-free samples of every run of a case, by channel [SI], with its effects or without.

    What a sensor without noise and converter would have recorded: the yardstick of the true closure.
    """
    recipe = recipe_from(answer["recipe"])
    return [
        sampled(recipe, index, noise_free(recipe, index, with_effects)) for index in range(len(recipe.runs))
    ]
