"""Constants where no record tells which effect of a class acts: they are as uncertain as its effects differ.

A gain of the force and one of the displacement leave the same trace, but a force that is read too large makes
friction too large, and a displacement that is makes the contact too soft.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.estimates import Estimates
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.which.attribute import Attribution
from fitting.diagnosis.which.explanation import Explanation
from fitting.result import Constant

AS_GOOD = 1.1
"""Effects of a class count that leave no more than so many times what the named one does."""

Times = Mapping[str, float]
"""How many times as large each constant is under another effect of the class."""


def over_class(model: Model, found: Attribution, named: Explanation, under_it: Estimates) -> Estimates:
    """Estimates with intervals of constants, and of the rig, that hold what these would be under the other
    effects of the classes of what is named, too."""
    others = under_others(model, found, named)
    return under_it._replace(
        constants=tuple(widened(constant, others) for constant in under_it.constants),
        others=tuple(widened(constant, others) for constant in under_it.others),
    )


def under_others(model: Model, found: Attribution, named: Explanation) -> list[Times]:
    """What becomes of the constants under these, each in the place of the one that it is not told from."""
    instead = {
        frozenset({*named.keys} - {key} | {other})
        for key, *others in found.judgement.same
        for other in others
    }
    most = AS_GOOD * named.refit.misfit
    refits = [e.refit for e in found.explanations if frozenset(e.keys) in instead and e.refit.misfit <= most]
    here = _values(model, named.refit)
    return [
        {name: value / here[name] for name, value in _values(model, each).items() if here.get(name)}
        for each in refits
    ]


def widened(constant: Constant, others: Sequence[Times]) -> Constant:
    """A constant with an interval that holds what it would be under others, too."""
    low, high, error = constant.low, constant.high, constant.standard_error
    if low is None or high is None or error is None or not low < high:
        return constant
    times = [1.0, *(each.get(constant.name, 1.0) for each in others)]
    ends = [end * factor for end in (low, high) for factor in times]
    wider = (max(ends) - min(ends)) / (high - low)
    return dataclasses.replace(constant, low=min(ends), high=max(ends), standard_error=error * wider)


def _values(model: Model, fit: Refit) -> dict[str, float]:
    return model.values(fit.point.coordinates, [model.names[number] for number in fit.free.tolist()])
