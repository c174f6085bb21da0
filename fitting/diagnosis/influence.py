"""How much a single lane says for an explanation.

A lane that loses an event costs a good deal under one hypothesis and little under another, whatever the two
say of the rig; and one cycle in which a rig did something else is no effect either. What acts on the rig is
seen in more than one lane: none says more for an explanation than all others together. On influential
observations: Cook, Weisberg, Residuals and Influence in Regression, Chapman and Hall 1982, section 3.1.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fitting.diagnosis.bench import Bench
from fitting.diagnosis.refit import Refit, misfit_of


def heard(before: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """The cost of every lane, where the one that gains most since `before` gains no more than all others
    together."""
    gained = before - cost
    loudest = int(np.argmax(gained))
    others = max(float(gained.sum() - gained[loudest]), 0.0)
    counted = cost.copy()
    counted[loudest] += max(float(gained[loudest]) - others, 0.0)
    return counted


def told_by_many(bench: Bench, fit: Refit, against: Iterable[Refit]) -> float:
    """The misfit of a refit, in which no lane says more for it than all others, compared with each of several
    others."""
    counted = np.max([fit.cost, *(heard(other.cost, fit.cost) for other in against)], axis=0)
    return fit.price(bench) * misfit_of(counted, bench.dof())
