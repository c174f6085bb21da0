"""Verdicts by what a rig is like: a fault of the diagnosis that only some rigs bring out shows here first."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import fisher_exact

from fitting.blind_score.intervals import share
from fitting.blind_score.judged import Judged

TRAITS: dict[str, Callable[[Mapping[str, Any]], bool]] = {
    "the base carries the guide": lambda recipe: bool(recipe["physics"]["against_base"]),
    "the base is recorded": lambda recipe: recipe["base"] is not None,
    "the noise is stated": lambda recipe: bool(recipe["stated"]["noise"]),
    "the frequencies are stated": lambda recipe: bool(recipe["stated"]["frequency"]),
    "all springs lead to the drive": lambda recipe: (
        recipe["physics"]["drive_stiffness"] == recipe["physics"]["stiffness"]
    ),
    "damping to the drive": lambda recipe: recipe["physics"]["drive_damping"] > 0.0,
}
"""What a rig may be like or not in any tier, told from the recipe of its case."""


def by_rig(cases: Sequence[Judged]) -> dict[str, dict[str, Any]]:
    """For every trait the share of right verdicts `with` and `without` it, and `p`, the probability that
    chance alone parts them as much (Fisher, J. R. Stat. Soc. 85 (1922) 87, two-sided).

    Traits that all of the cases share, or none has, are left out. Of six p one is below 0.05 by chance in one
    set of four.
    """
    found = {}
    for trait, so in TRAITS.items():
        groups: dict[bool, list[bool]] = {True: [], False: []}
        for case in cases:
            groups[so(case.answer["recipe"])].append(case.right())
        if all(groups.values()):
            table = [[sum(group), len(group) - sum(group)] for group in groups.values()]
            found[trait] = {
                "with": share(groups[True]),
                "without": share(groups[False]),
                "p": float(np.asarray(fisher_exact(table))[1]),
            }
    return found
