"""The constants before and after: what the missing effect bent."""

from __future__ import annotations

from typing import Any

from fitting.against import stated
from fitting.report.section import Number, Section, Subject
from fitting.report.words import NOTHING, estimate, interval
from fitting.result import Constant
from fitting.save import constant_entry


def constants(subject: Subject) -> Section:
    """A row for each constant, and for what was free within its tolerance: assumed, fitted without and with
    the named effects."""
    diagnosis = subject.diagnosis
    after = {constant.name: constant for constant in (*diagnosis.constants, *diagnosis.others)}
    before = {constant.name: constant for constant in (*diagnosis.constants_before, *diagnosis.others_before)}
    names = list(dict.fromkeys((*after, *before)))
    content = {
        "rows": [_row(name, before.get(name), after.get(name)) for name in names],
        "effects": bool(diagnosis.effects),
    }
    return Section("constants", "Constants before and after", "constants.html", content)


def _row(name: str, before: Constant | None, after: Constant | None) -> dict[str, Any]:
    present = after or before
    assert present is not None
    change = ""
    if before is not None and after is not None and before.value and after.identifiable:
        change = f"{round(100 * (after.value / before.value - 1), 1) + 0.0:+.1f} %"
    return {
        "name": name,
        "unit": present.unit,
        "assumed": stated(present.assumed),
        "before": _number(before),
        "after": _number(after),
        "change": change or NOTHING,
        "remark": constant_entry(present)["remark"],
    }


def _number(constant: Constant | None) -> Number:
    if constant is None:
        return Number(NOTHING)
    ends = constant.value, constant.low, constant.high
    return Number(estimate(*ends), interval(*ends))
