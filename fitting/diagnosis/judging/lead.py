"""Whether one effect explains far more than every other.

An effect that acts in another shape than the shelf has still finds its own there: that one leaves something,
and every other far more. What is off the shelf resembles several listed effects a little, and none of them
much more than the next. The best left less than half of what the second did in 2 of 21 sealed cases with an
effect off the shelf, and in 11 of 20 with a listed one that had left a twelfth of the excess and more.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

PER_HALF, AT_FIRST, MOST = 3.0, 1.0, 4.0
"""What every halving of what the second leaves is worth (logarithm of a likelihood ratio), what is taken off
that, and what it comes to at most."""
SHAPE = 0.03
"""The share of the excess that is added to what either leaves: less depends on the shape in any case."""
LITTLE, MUCH = 0.25, 0.35
"""Shares of the excess left by the best between which its lead ceases to count."""
NOTHING, SOMETHING = 1.1, 1.4
"""Misfits of the nominal model between which a lead comes to count: so close to the noise it is chance."""


def lead(misfits: Mapping[str, float], nominal: float, same: Mapping[str, Collection[str]]) -> float:
    """By how much the best single effect's lead speaks for it, against what is off the shelf (logarithm of a
    likelihood ratio, 0 and more).

    misfits: what single effects leave; nominal: what none leaves, both over the noise; same: the effects that
    are not told from an effect, which are not what it leads by.
    """
    excess = nominal - 1.0
    if not misfits or excess <= 0:
        return 0.0
    best = min(misfits, key=lambda key: misfits[key])
    others = (misfit for key, misfit in misfits.items() if key != best and key not in same.get(best, ()))
    first, second = (
        max(left - 1.0, 0.0) + SHAPE * excess for left in (misfits[best], min([nominal, *others]))
    )
    worth = PER_HALF * math.log2(second / first) - AT_FIRST
    counts = float(np.interp(nominal, (NOTHING, SOMETHING), (0.0, 1.0)))
    counts *= float(np.interp((misfits[best] - 1.0) / excess, (LITTLE, MUCH), (1.0, 0.0)))
    return counts * min(max(worth, 0.0), MOST)
