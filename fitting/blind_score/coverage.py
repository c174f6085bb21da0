"""Whether intervals hold the true values as often as they promise."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any

from fitting.blind_score.intervals import share
from fitting.blind_score.judged import NONE, SINGLE, Judged

TIER = "A"
"""The tier whose formulas are the catalogue's, so that a true value of each parameter exists."""


def coverage(cases: Sequence[Judged]) -> dict[str, Any]:
    """The share of intervals that hold the true value, in cases of tier A.

    Parameters: of effects that are the truth and the only ones in the final model. Constants: in those cases
    and in the effect-free ones that were called so; `constants_before`, with `error_before` and `error_after`
    (median relative errors), in the former alone. What the data do not bound (no interval) is counted apart.
    A parameter whose name or unit is not the truth's is named under `not_compared`.
    """
    of_tier = [case for case in cases if case.tier == TIER and case.result is not None]
    with_effect = [case for case in of_tier if case.kind == SINGLE and _holds(case)]
    free = [case for case in of_tier if case.kind == NONE and case.verdict == NONE]
    parameters: list[bool] = []
    unbounded, strange = 0, set()
    for case in with_effect:
        key = case.truth[0]
        for name, true, entry in _pairs(case, key):
            if entry is None or entry["unit"] != true["unit"]:
                strange.add(f"{key}.{name}")
                continue
            held = holds(entry, true["value"])
            unbounded += held is None
            parameters += [] if held is None else [held]
    return {
        "cases": len(with_effect),
        "parameters": share(parameters),
        "parameters_unbounded": unbounded,
        "not_compared": sorted(strange),
        "constants": _constants([*with_effect, *free], "constants"),
        "constants_before": _constants(with_effect, "constants_before"),
        "error_after": _errors(with_effect, "constants"),
        "error_before": _errors(with_effect, "constants_before"),
    }


def holds(entry: Mapping[str, Any], true: float) -> bool | None:
    """Whether an interval holds the true value; a side that is null is open, both null is no interval (None).

    An angle [rad] is the same after a full turn.
    """
    low, high = entry["low"], entry["high"]
    if low is None and high is None:
        return None
    if entry["unit"] == "rad" and entry["value"] is not None:
        true += 2 * math.pi * round((entry["value"] - true) / (2 * math.pi))
    return (low is None or low <= true) and (high is None or true <= high)


def _holds(case: Judged) -> bool:
    return case.right() and case.result is not None and tuple(case.result["effects"]) == case.truth


def _pairs(case: Judged, key: str) -> list[tuple[str, dict[str, Any], Mapping[str, Any] | None]]:
    """Every true parameter of the effect with what was found for it.

    A strength of the other sign is the same effect half a turn on, where the effect has an angle.
    """
    assert case.result is not None
    true = {name: dict(entry) for name, entry in case.answer["effects"][key]["parameters"].items()}
    found = case.result["effects"][key]["parameters"]
    angles = [name for name, entry in true.items() if entry["unit"] == "rad"]
    turned = [
        name
        for name, entry in true.items()
        if name not in angles and name in found and entry["value"] * (found[name]["value"] or 0.0) < 0
    ]
    if angles and len(turned) == 1:
        true[turned[0]]["value"] *= -1
        for name in angles:
            true[name]["value"] += math.pi
    return [(name, entry, found.get(name)) for name, entry in true.items()]


def _constants(cases: Sequence[Judged], where: str) -> dict[str, Any]:
    """Coverage of each constant, of all together, and how many had no interval."""
    held: dict[str, list[bool]] = {}
    unbounded = 0
    for case in cases:
        for name, entry, true in _true_constants(case, where):
            inside = holds(entry, true)
            unbounded += inside is None
            held.setdefault(name, [])
            held[name] += [] if inside is None else [inside]
    return {
        "all": share([inside for some in held.values() for inside in some]),
        "unbounded": unbounded,
        **{name: share(some) for name, some in held.items()},
    }


def _errors(cases: Sequence[Judged], where: str) -> dict[str, float]:
    errors: dict[str, list[float]] = {}
    for case in cases:
        for name, entry, true in _true_constants(case, where):
            if entry["value"] is not None and true:
                errors.setdefault(name, []).append(abs(entry["value"] / true - 1))
    return {name: median(some) for name, some in errors.items()}


def _true_constants(case: Judged, where: str) -> list[tuple[str, Mapping[str, Any], float]]:
    assert case.result is not None
    found = case.result.get(where) or {}
    return [(name, found[name], true) for name, true in case.answer["constants"].items() if name in found]
