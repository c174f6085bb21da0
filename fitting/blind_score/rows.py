"""A score in words: the rows of its tables, for terminal and page alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

ANSWERS = (
    ("top1", "one effect: named first", "≥ 95 %"),
    ("top1_strong", "one effect, gap at least 3 times the noise: named first", "≥ 95 %"),
    ("top2", "one effect: among the first two", ""),
    ("probability", "one effect: mean probability of the truth and its exact aliases", "≥ 90 %"),
    ("probability_exact", "one effect: mean probability of the truth alone", ""),
    ("family", "one effect: family right", "≥ 98.5 %"),
    ("none_called", "no effect: called none", "≥ 98 %"),
    ("false_alarms", "no effect: an effect is named", ""),
    ("unlisted_called", "effect off the shelf: called unlisted", ""),
    ("unlisted_called_strong", "effect off the shelf, gap at least 3: called unlisted", "≥ 85 %"),
    ("auroc", "area under the ROC curve of p(unlisted)", "≥ 95 %"),
    ("listed_called_unlisted", "one effect: called unlisted", "≤ 3 %"),
    ("pairs_right", "two effects: both named and no third", "≥ 80 %"),
    ("pairs_both", "two effects: both named", ""),
    ("pairs_one", "two effects: at least one named", "≥ 99 %"),
    ("pairs_third", "two effects: a third named", ""),
    ("aliases_as_class", "exact aliases: answered as the class", "100 %"),
    ("aliases_alone", "exact aliases: one name alone", "0 %"),
    ("right", "all cases: verdict right", ""),
)
"""Key, what it says, and what is asked for."""

Row = tuple[str, ...]


def answer_columns(score: Mapping[str, Any]) -> Row:
    """The columns of `answer_rows`."""
    return ("figure", *score["tiers"], "asked for", "n", "chance", "BIC", "signature")


def answer_rows(score: Mapping[str, Any]) -> list[Row]:
    """Verdicts and probabilities: all and by tier with 95 % intervals, beside chance and baselines."""
    tiers, beside = score["tiers"], score["baselines"]
    rows = []
    for key, title, asked in ANSWERS:
        if tiers["all"][key]["value"] is None:
            continue
        rows.append(
            (
                title,
                *(figure(tier[key]) for tier in tiers.values()),
                asked,
                str(tiers["all"][key]["n"]),
                percent(beside["chance"].get(key)),
                percent(beside["bic"]["all"][key]["value"]),
                percent(beside["signature"]["all"][key]["value"]),
            )
        )
    return rows


def further_columns(score: Mapping[str, Any]) -> Row:
    """The columns of `further_rows`."""
    return ("figure", *score["tiers"], "asked for")


def further_rows(score: Mapping[str, Any]) -> list[Row]:
    """Calibration, intervals and closure: all and by tier."""
    tiers = score["tiers"].values()
    rows = [
        (each.title, *(each.words(each.of(tier)) for tier in tiers), each.asked) for each in FURTHER.values()
    ]
    return [row for row in rows if any(cell != "-" for cell in row[1:-1])]


EFFECT_COLUMNS = (
    "effect",
    "family",
    "n",
    "named first",
    "probability",
    "beyond 1.5 predicted limits",
    "predicted limits for 9 of 10",
    "beyond 1.5 ideal limits",
    "ideal limits for 9 of 10",
)


def effect_rows(score: Mapping[str, Any]) -> list[Row]:
    """One row for every effect that acted alone."""
    return [
        (
            key,
            one["family"],
            str(one["top1"]["n"]),
            figure(one["top1"]),
            percent(one["probability"]["value"]),
            figure(one.get("named_beyond_predicted")),
            figure(one.get("a90_predicted"), number),
            figure(one["named_beyond"]),
            figure(one["a90"], number),
        )
        for key, one in score["effects"].items()
        if one["top1"]["n"]
    ]


RIG_COLUMNS = ("rig", "right where it is so", "right elsewhere", "p of the difference")


def rig_rows(score: Mapping[str, Any]) -> list[Row]:
    """How often verdicts are right by what a rig is like; records of early scores do not have it."""
    return [
        (trait, _counted(one["with"]), _counted(one["without"]), number(one["p"]))
        for trait, one in score.get("rigs", {}).items()
    ]


CONSTANT_COLUMNS = (
    "constant",
    "in the interval",
    "without the effect",
    "median error",
    "without the effect ",
)


def constant_rows(score: Mapping[str, Any]) -> list[Row]:
    """Coverage and median relative error of every constant, with the effect in the model and without."""
    found = score["tiers"]["all"]["coverage"]
    return [
        (
            name,
            figure(found["constants"].get(name)),
            figure(found["constants_before"].get(name)),
            percent(found["error_after"].get(name)),
            percent(found["error_before"].get(name)),
        )
        for name in found["constants"]
        if name not in ("all", "unbounded")
    ]


RELIABILITY_COLUMNS = ("confidence", "mean", "right", "n")


def reliability_rows(score: Mapping[str, Any]) -> list[Row]:
    """The reliability table of all cases."""
    return [
        (
            f"{percent(one['low'])} to {percent(one['high'])}",
            percent(one["confidence"]),
            figure(one["right"]),
            str(one["right"]["n"]),
        )
        for one in score["tiers"]["all"]["calibration"]["bins"]
    ]


CONFUSION_COLUMNS = ("truth", "n", "answers")


def confusion_rows(score: Mapping[str, Any]) -> list[Row]:
    """What each truth was taken for."""
    return [
        (truth, str(sum(row.values())), ", ".join(f"{answer} {count}" for answer, count in row.items()))
        for truth, row in score["confusion"].items()
    ]


MISTAKE_COLUMNS = ("case", "tier", "truth", "gap", "answer", "p(truth)")


def mistake_rows(score: Mapping[str, Any]) -> list[Row]:
    """Every case whose verdict was wrong."""
    return [
        (
            one["case"],
            one["tier"],
            " + ".join(one["truth"]),
            number(one["gap"]),
            one.get("error") or f"{one['verdict']} {', '.join(one['named'])}".strip(),
            percent(one["probability"]),
        )
        for one in score["mistakes"]
    ]


def sentence(score: Mapping[str, Any]) -> str:
    """The score in one sentence."""
    whole = score["tiers"]["all"]
    parts = [
        f"{title} in {figure(whole[key])}"
        for key, title in (
            ("top1", "the one effect is named"),
            ("none_called", "effect-free data are called so"),
            ("unlisted_called", "what is off the shelf is called unlisted"),
            ("pairs_right", "both of two are named"),
        )
        if whole[key]["n"]
    ]
    said = "; ".join(parts) if parts else "nothing to score"
    count, every = score["cases"], score["set"].get("cases", score["cases"])
    return f"{said[0].upper()}{said[1:]} ({count if count == every else f'{count} of {every}'} cases)."


def percent(value: float | None) -> str:
    """A share as people read it: two digits, one more close to 0 and 100 %."""
    if value is None:
        return "-"
    shown = 100 * value
    return f"{shown:.1f} %" if abs(shown) < 10 or 90 < shown < 100 else f"{shown:.0f} %"


def number(value: float | None) -> str:
    """A number with three digits."""
    return "-" if value is None else f"{value:.3g}"


def figure(found: Mapping[str, Any] | None, shown: Any = percent) -> str:
    """A figure with its interval: '97.5 % (95.5 to 98.8)'."""
    if found is None or found["value"] is None:
        return "-"
    low, high = (shown(found[end]).removesuffix(" %") for end in ("low", "high"))
    return f"{shown(found['value'])} ({low} to {high})"


def _counted(found: Mapping[str, Any]) -> str:
    return f"{found['hits']} of {found['n']}, {figure(found)}"


def _ece(found: Mapping[str, Any]) -> str:
    return "-" if found["ece"] is None else f"{number(found['ece'])} ({number(found['perfect'])})"


class Further(NamedTuple):
    """A figure of a tier: what it says, what is asked for, where a tier has it, and how it is written."""

    title: str
    asked: str
    of: Callable[[Mapping[str, Any]], Any]
    words: Callable[[Any], str]


def _in_numbers(found: Mapping[str, Any] | None) -> str:
    return figure(found, number)


FURTHER = {
    "ece": Further(
        "expected calibration error (at most, for a perfect diagnoser)",
        "within",
        lambda tier: tier["calibration"],
        _ece,
    ),
    "log_loss": Further(
        "log-loss [nat]", "≤ 0.35", lambda tier: tier["calibration"]["log_loss"], _in_numbers
    ),
    "brier": Further("Brier score", "", lambda tier: tier["calibration"]["brier"], _in_numbers),
    "parameters": Further(
        "parameters in their intervals", "93 to 97 %", lambda tier: tier["coverage"]["parameters"], figure
    ),
    "constants": Further(
        "constants in their intervals",
        "93 to 97 %",
        lambda tier: tier["coverage"]["constants"]["all"],
        figure,
    ),
    "constants_before": Further(
        "constants in their intervals, without the effect",
        "",
        lambda tier: tier["coverage"]["constants_before"]["all"],
        figure,
    ),
    "median": Further(
        "share of the gap closed, median", "≥ 97 %", lambda tier: tier["closure"]["median"], figure
    ),
    "tenth": Further(
        "share of the gap closed, 10 % quantile", "", lambda tier: tier["closure"]["tenth"], figure
    ),
    "covered": Further(
        "share closed, the interval holds the truth (tier A)",
        "93 to 97 %",
        lambda tier: tier["closure"].get("covered"),
        figure,
    ),
    "placebo": Further("placebo closes, median", "0 ± 5 %", lambda tier: tier["closure"]["placebo"], figure),
    "margin": Further(
        "at least 0.2 beyond the best wrong class", "≥ 85 %", lambda tier: tier["closure"]["margin"], figure
    ),
    "named_beyond_predicted": Further(
        "named beyond 1.5 predicted limits",
        "≥ 90 %",
        lambda tier: tier["limits"].get("named_beyond_predicted"),
        figure,
    ),
    "effects_beyond_predicted": Further(
        "effects named in 9 of 10 cases beyond 1.5 predicted limits",
        "≥ 90 %",
        lambda tier: tier["limits"].get("effects_beyond_predicted"),
        figure,
    ),
    "predicted_ratio": Further(
        "predicted limits at which 9 of 10 are named",
        "≤ 1.5",
        lambda tier: (tier["limits"].get("predicted_ratio") or {}).get("a90"),
        _in_numbers,
    ),
    "not_predicted": Further(
        "one effect, but no predicted limit to compare with: cases",
        "",
        lambda tier: tier["limits"].get("not_predicted", "-"),
        str,
    ),
    "named_beyond": Further(
        "named beyond 1.5 limits of an ideal observer",
        "",
        lambda tier: tier["limits"]["named_beyond"],
        figure,
    ),
    "limit_ratio": Further(
        "limits of an ideal observer at which 9 of 10 are named",
        "",
        lambda tier: (tier["limits"]["limit_ratio"] or {}).get("a90"),
        _in_numbers,
    ),
}
"""Calibration, intervals and closure, by what the score calls them."""
