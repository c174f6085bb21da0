"""An identified constant against the assumed one, in numbers and in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


def against(entry: Mapping[str, Any], assumed: float | None) -> dict[str, Any]:
    """A constant's entry in fit.json set against `assumed`.

    entry: value, low, high, standard_error. Added are `assumed`, `ratio` = value / assumed,
    `standard_errors` = (value - assumed) / standard error, `inside`: whether assumed lies in the 95 %
    interval, and `remark`. What cannot be said is None.
    """
    value, error = entry["value"], entry.get("standard_error")
    low, high = entry["low"], entry["high"]
    inside = None
    if assumed is not None and not (low is None and high is None):
        inside = (low is None or assumed >= low) and (high is None or assumed <= high)
    return {
        **entry,
        "assumed": assumed,
        "ratio": value / assumed if assumed else None,
        "standard_errors": None if assumed is None or not error else (value - assumed) / error,
        "inside": inside,
        "remark": _remark(low, high, inside),
    }


def _remark(low: float | None, high: float | None, inside: bool | None) -> str:
    bounded = {
        (True, True): "not bounded by these records",
        (True, False): "bounded only above",
        (False, True): "bounded only below",
        (False, False): "",
    }[low is None, high is None]
    judged = {None: "", True: "agrees", False: "differs"}[inside]
    return ", ".join(part for part in (bounded, judged) if part)


def figures(value: float | None, spread: float | None = None) -> str:
    """A number with two figures of its spread (four figures of its own where none is known)."""
    if value is None:
        return "-"
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    size = math.floor(math.log10(abs(value)))
    own = 4 if not spread else size - math.floor(math.log10(spread)) + 2
    kept = min(max(own, 2), 8)
    if -5 < size < 7:
        decimals = kept - 1 - size
        return f"{round(value, decimals):.{max(decimals, 0)}f}"
    return f"{value:.{kept - 1}e}"


def stated(value: float | None) -> str:
    """A number as it was stated, to five figures and without trailing zeros."""
    if value is None:
        return "-"
    if value == 0 or not -5 < math.floor(math.log10(abs(value))) < 7:
        return f"{value:.5g}"
    decimals = max(4 - math.floor(math.log10(abs(value))), 0)
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
