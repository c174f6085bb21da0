"""How much a single lane says for an explanation.

A lane that loses an event costs a good deal under one hypothesis and little under another, whatever the two
say of the rig; and one cycle in which a rig did something else is no effect either. What acts on the rig is
seen in more than one lane: where the others say little for an explanation, none says more than all of them,
and none says more against it than all others do.
On influential observations: Cook, Weisberg, Residuals and Influence in Regression, Chapman and Hall 1982,
section 3.1.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.refits.refit import Refit
from fitting.newton import Robust

ENOUGH = 30.0
"""Where all lanes but the loudest gain so much chi-square, they would be believed without it."""


def heard(before: np.ndarray, now: np.ndarray) -> np.ndarray:
    """The loss of every lane, where the one that gains most since `before` gains no more than all others
    together, unless these gain `ENOUGH`."""
    loudest, others, more = _apart(before - now)
    if others >= ENOUGH:
        return now
    counted = now.copy()
    counted[loudest] += more
    return counted


def spared(loss: np.ndarray, dof: np.ndarray) -> np.ndarray:
    """The loss of every lane, where the one that keeps most beyond its noise keeps no more of that than all
    others together."""
    loudest, _, more = _apart(loss - dof)
    counted = loss.copy()
    counted[loudest] -= more
    return counted


def _apart(amounts: np.ndarray) -> tuple[int, float, float]:
    """The lane that has most, what all others have together, and how much more than that it has."""
    loudest = int(np.argmax(amounts))
    others = float(amounts.sum() - amounts[loudest])
    return loudest, others, max(float(amounts[loudest]) - max(others, 0.0), 0.0)


def told_by_many(bench: Bench, fit: Refit, against: Iterable[Refit] = ()) -> float:
    """The misfit of a refit as it is `heard`, compared with each of several others, all of them `spared`.
    What a lane loses counts as in every misfit, outliers weighed down."""
    dof = bench.dof()

    def loss(one: Refit) -> np.ndarray:
        return spared(Robust.around(one.cost, dof).each(one.cost), dof)

    own = loss(fit)
    counted = np.max([own, *(heard(loss(other), own) for other in against)], axis=0)
    return fit.price(bench) * float(counted.sum() / dof.sum())
