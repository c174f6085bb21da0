"""A diagnosis as tables and sentences for a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fitting.report.words import (
    NOTHING,
    VERDICTS,
    estimate,
    interval,
    is_number,
    largest,
    listed,
    number,
    percent,
    ranked,
    share_interval,
    with_unit,
)
from fitting.show import show_constants
from jaxstick.terminal import Terminal

LIKELIEST = 5


def show_diagnosis(content: Mapping[str, Any], terminal: Terminal) -> None:
    """The summary of a diagnosis, from what diagnosis.json holds."""
    terminal.say(VERDICTS[content["verdict"]], "bold")
    terminal.say(content["sentence"])
    terminal.say()
    terminal.table("Where, which, how far", ("question", "answer"), _answers(content))
    terminal.table(
        "Probabilities",
        ("explanation", "probability"),
        [(key, percent(share)) for key, share in ranked(content["probabilities"], LIKELIEST)],
    )
    if content["effects"]:
        terminal.table(
            "Named effects",
            ("effect", "parameter", "value", "95 % interval"),
            [
                (
                    key,
                    name,
                    with_unit(estimate(*_ends(entry)), entry["unit"]),
                    with_unit(interval(*_ends(entry)), entry["unit"]),
                )
                for key, effect in content["effects"].items()
                for name, entry in effect["parameters"].items()
            ],
        )
    show_constants({**content["constants"], **content["others"]}, terminal)
    if content["notes"]:
        terminal.say("What weakens it", "bold")
        terminal.bullets(content["notes"])
        terminal.say()
    if content["next_experiment"]:
        terminal.say(f"Next experiment: {content['next_experiment']}")


def _answers(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    where, gap = content["where"], content["gap"]
    answers = []
    if content["verdict"] != "none":
        for kind in ("side", "channel", "phase", "run"):
            found = largest({name: share for name, share in where[kind].items() if share is not None})
            if found is not None:
                answers.append((f"where: {kind}", f"{found[0]}, {percent(found[1])} of the excess"))
    answers.append(("which", _named(content)))
    gaps = [
        f"{label} {number(gap[key])}"
        for key, label in (
            ("assumed", "assumed constants"),
            ("before", "nominal fitted"),
            ("after", "with the effect"),
            ("floor", "noise"),
        )
        if is_number(gap[key]) and (key != "after" or content["effects"])
    ]
    answers.append(("how far: gap [sd of the noise]", ", ".join(gaps)))
    answers.append(("how far: closed", _closed(content)))
    judged = listed(gap["held_out"]) or "the records"
    answers.append(("judged on", f"segments of {judged}" if gap["by_segments"] else judged))
    return answers


def _named(content: Mapping[str, Any]) -> str:
    """What is named: what cannot be told apart, or two together and what may be in the place of one."""
    named = content["named"]
    if content["verdict"] != "several":
        return " or ".join(named) or content["verdict"]
    together = " with ".join(key for key in named if key in content["effects"])
    instead = " or ".join(key for key in named if key not in content["effects"])
    return f"{together}, or {instead} in the place of one" if instead else together


def _closed(content: Mapping[str, Any]) -> str:
    gap = content["gap"]
    if not content["effects"] or not is_number(gap["closed"]):
        return NOTHING
    low, high = gap["closed_interval"]
    if not (is_number(low) and is_number(high)):
        return percent(gap["closed"])
    return f"{percent(gap['closed'])} (95 % interval {share_interval(low, high)})"


def _ends(entry: Mapping[str, Any]) -> tuple[float | None, float | None, float | None]:
    return entry["value"], entry["low"], entry["high"]
