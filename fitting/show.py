"""Fits and comparisons as tables and sentences for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fitting.against import figures, stated
from jaxstick.check import quantity
from jaxstick.terminal import Terminal, stops_text

AT_THE_FLOOR = 1.3
"""Up to this chi^2 a sample what a fit leaves is called noise."""


def show_fit(content: Mapping[str, Any], terminal: Terminal) -> None:
    """The summary of a fit, from what fit.json holds."""
    show_constants({**content["constants"], **content["others"]}, terminal)
    free = {run["file"]: run["rms_displacement_m"] for run in content["free_run"]}
    held_out = {run["file"] for run in content["runs"] if run["hold_out"]}
    terminal.table(
        "What the fit leaves (root mean square)",
        ("run", "use", "channel", "left", "noise", "left/noise", "free run"),
        [
            (
                gap["file"],
                "held out" if gap["file"] in held_out else "fit",
                gap["channel"],
                quantity(gap["rms"], gap["unit"]),
                quantity(gap["floor"], gap["unit"]),
                f"{gap['rms'] / gap['floor']:.2f}",
                quantity(free[gap["file"]], "m") if gap["channel"] == "displacement" else "-",
            )
            for gap in content["gap"]["runs"]
        ],
    )
    for sentence in _sentences(content):
        terminal.say(sentence)


def show_constants(entries: Mapping[str, Mapping[str, Any]], terminal: Terminal) -> None:
    """A table of constants as `fitting.against` describes them."""
    terminal.table(
        "Constants",
        ("constant", "unit", "identified", "95 % interval", "assumed", "ratio", "s.e. apart", "remark"),
        [
            (
                name,
                entry["unit"],
                figures(entry["value"], _spread(entry)),
                _interval(entry),
                stated(entry["assumed"]),
                "-" if entry["ratio"] is None else f"{entry['ratio']:.3f}",
                _apart(entry["standard_errors"]),
                entry["remark"],
            )
            for name, entry in entries.items()
        ],
    )


def show_comparison(comparison: Mapping[str, Any], terminal: Terminal) -> None:
    """The summary of a comparison, from the object that `jaxstick compare --json` prints."""
    show_constants({**comparison["constants"], **comparison["others"]}, terminal)
    runs = comparison["runs"]
    if runs:
        terminal.table(
            "Periodic motion: amplitude and stops a cycle",
            (
                "run",
                "drive",
                "f/fn",
                *("amplitude\nrecorded", "\nassumed", "\nidentified"),
                *("stops\nrecorded", "\nassumed", "\nidentified"),
            ),
            [
                (
                    run["file"],
                    quantity(run["frequency_hz"], "Hz"),
                    quantity(run["frequency_ratio"], ""),
                    *(_part(run[case], "amplitude_m", "m") for case in ("measured", "assumed", "identified")),
                    *(_part(run[case], "stops", "") for case in ("measured", "assumed", "identified")),
                )
                for run in runs
            ],
        )
    exchanged = [run for run in runs if run["exchanged"]]
    if exchanged:
        names = list(exchanged[0]["exchanged"])
        terminal.table(
            "What each identified constant alone changes: amplitude, and stops a cycle where they change",
            ("run", *names),
            [
                (run["file"], *(_change(run["assumed"], run["exchanged"][name]) for name in names))
                for run in exchanged
            ],
        )
    for sentence in (*_motion_sentences(runs), *comparison["notices"]):
        terminal.say(sentence)


def _fitted(key: str, content: Mapping[str, Any]) -> bool:
    """Whether parameters of an effect were free in a fit."""
    return any(name.startswith(f"{key}.") for name in content["others"])


def _sentences(content: Mapping[str, Any]) -> Iterator[str]:
    constants = content["constants"]
    held = [key for key in content.get("effects", {}) if not _fitted(key, content)]
    if held:
        yield f"{_listed(held)} {'acts' if len(held) == 1 else 'act'} as the rig file states."
    loose = [name for name, entry in constants.items() if not entry["identifiable"]]
    if loose:
        yield (
            f"{_listed(loose)} {'is' if len(loose) == 1 else 'are'} not bounded on both sides by these "
            f"records: other values of {'it' if len(loose) == 1 else 'them'} fit as well."
        )
    if content.get("runs_disagree"):
        yield (
            "The runs differ in what they say of the constants by more than chance; the intervals hold it: "
            "friction may differ from run to run, or the model lack something (diagnose)."
        )
    apart = {
        name: entry
        for name, entry in constants.items()
        if entry["inside"] is False and entry["ratio"] and entry["identifiable"]
    }
    if apart:
        name = max(apart, key=lambda key: abs(apart[key]["ratio"] - 1))
        entry = apart[name]
        yield (
            f"Farthest from the assumed value is {name}: {figures(entry['value'], _spread(entry))} "
            f"{entry['unit']} against {stated(entry['assumed'])} assumed, "
            f"{100 * (entry['ratio'] - 1):+.0f} %."
        )
    chi2 = content["gap"]["chi2_per_sample"]
    if chi2 <= AT_THE_FLOOR:
        yield f"What is left is noise: chi2 a sample is {chi2:.2f}, and would be 1 for a perfect model."
    else:
        yield (
            f"What is left is {chi2**0.5:.1f} times the noise (chi2 a sample {chi2:.3g}): the records show "
            "something that this model lacks (jaxstick diagnose looks for it), or the noise is stated too "
            "small."
        )
    number, excluded = content["segments"]["number"], content["segments"]["excluded"]
    if excluded:
        yield f"{excluded} of {number} segments fit far worse than the rest and were given less weight."


def _motion_sentences(runs: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    both = [run for run in runs if run["assumed"] is not None]
    if both:
        change = max(
            abs(run["identified"]["amplitude_m"] / run["assumed"]["amplitude_m"] - 1) for run in both
        )
        other = sum(not _same_stops(run["identified"], run["assumed"]) for run in both)
        yield (
            f"The identified constants change the amplitude by up to {100 * change:.1f} % and the number of "
            f"stops in {other} of {len(both)} runs."
        )
    measured = [run for run in both if run["measured"] is not None]
    if measured:
        met = {
            case: sum(_same_stops(run[case], run["measured"]) for run in measured)
            for case in ("identified", "assumed")
        }
        yield (
            f"The recorded number of stops is met in {met['identified']} of {len(measured)} runs by the "
            f"identified constants, in {met['assumed']} by the assumed ones."
        )


def _same_stops(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two motions stop equally often, to half a stop a cycle."""
    return abs(one["stops"] - other["stops"]) < 0.5


def _spread(entry: Mapping[str, Any]) -> float | None:
    ends = [abs(end - entry["value"]) for end in (entry["low"], entry["high"]) if end is not None]
    return (min(end for end in ends if end) if any(ends) else None) or entry["standard_error"]


def _interval(entry: Mapping[str, Any]) -> str:
    spread = _spread(entry)
    low, high = (figures(entry[end], spread) for end in ("low", "high"))
    if entry["low"] is None and entry["high"] is None:
        return "-"
    if entry["low"] is None:
        return f"up to {high}"
    if entry["high"] is None:
        return f"from {low}"
    return f"{low} to {high}"


def _apart(standard_errors: float | None) -> str:
    if standard_errors is None:
        return "-"
    return f"{standard_errors:+.1f}" if abs(standard_errors) < 100 else f"{standard_errors:+.0f}"


def _part(case: Mapping[str, Any] | None, key: str, unit: str) -> str:
    if case is None:
        return "-"
    return quantity(case[key], unit) if unit else stops_text(case[key])


def _change(before: Mapping[str, Any], after: Mapping[str, Any]) -> str:
    change = after["amplitude_m"] / before["amplitude_m"] - 1 if before["amplitude_m"] else 0.0
    text = f"{round(100 * change, 1) + 0.0:+.1f} %"
    stops = stops_text(before["stops"]), stops_text(after["stops"])
    return text if stops[0] == stops[1] else f"{text}, {stops[0]} to {stops[1]}"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
