"""Single effects against none and against one another.

Whether one of them acts is decided by all the evidence there is, each paying for parameters of its own. Which
of them does is decided by less: what two effects leave differs by how sensors and converters round, and by
shapes that are a little other than on the shelf, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

AMONG = 30.0
"""Scores vary so many times as much as white noise says where two single effects are compared. In sealed
cases a wrong one had left 0.956, the right one 0.972. Friction that scatters is no reason for more, for it
hides either alike: in 96 sealed cases with scatter 84 right ones are so told instead of 82, log score -1.02
instead of -1.04."""
SHAPES = 0.1
"""Or what the two leave differs by chance by so much of all that the best explains (standard deviation): the
less that is, the more is told by a difference that is a good part of it. From 72 weak sealed cases, of which
31 instead of 26 are told; over 328 strong ones the logarithmic score is the same to four digits."""

Keys = tuple[str, ...]


class Single(NamedTuple):
    """What a single effect costs, and by how much evidence it lies behind the best: by all there is, and by
    what counts among single effects (logarithms). `cheaper`: by how much less it costs among them, where a
    parameter is found from less evidence."""

    price: float
    behind: float
    among: float
    cheaper: float = 0.0


def singly(singles: Mapping[Keys, Single], most: float) -> dict[Keys, float]:
    """The logarithms of how likely single effects are, compared with one that is as good as the best and
    costs nothing. `most`: by how much evidence the nominal model lies behind the best."""
    if not singles:
        return {}
    which = {keys: -_told(one, most) - one.price + one.cheaper for keys, one in singles.items()}
    any_of_them = np.logaddexp.reduce([-one.behind - one.price for one in singles.values()])
    whole = np.logaddexp.reduce(list(which.values()))
    return {keys: float(any_of_them - whole + log) for keys, log in which.items()}


def _told(one: Single, most: float) -> float:
    """By how much evidence an effect is told from the best."""
    if one.behind <= 0 or most <= 0:
        return max(one.among, 0.0)
    deviations = one.behind / (SHAPES * most)
    return max(one.among, min(one.behind, 0.5 * deviations * deviations))
