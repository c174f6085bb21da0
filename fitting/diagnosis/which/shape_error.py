"""What the shape of a named effect leaves open of everything that was fitted with it.

An effect that acts in another shape than the shelf has bends the constants, and more samples do not help.
By how much is told by the second effects that mend its shape in part: the systematic error of a model that is
varied (Barlow, Systematic errors: facts and fictions, Durham conference on statistics, 2002).
"""

from __future__ import annotations

import math

import numpy as np

from fitting.diagnosis.judging.judge import LEAST_INFLATION
from fitting.diagnosis.which.attribute import Attribution
from fitting.diagnosis.which.explanation import Explanation

CHANCE = 3.0
"""By less evidence than this (logarithm of a likelihood ratio) a second effect mends nothing."""


def shape_variance(found: Attribution, named: Explanation) -> np.ndarray:
    """Mean squares of the changes of what is free in a refit (coordinates) under the second effects that mend
    what it leaves above the noise, each counting by the share of that which it mends; nought where none
    does."""
    fit = named.refit
    noise = min(found.floor, fit.misfit)
    pieces = found.yardstick.samples / max(found.inflation, LEAST_INFLATION)
    total, squares = 0.0, np.zeros(len(fit.free))
    for other in found.explanations:
        evidence = 0.5 * pieces * math.log(fit.misfit / other.refit.misfit)
        if not {*named.keys} < {*other.keys} or evidence < CHANCE:
            continue
        mended = min((fit.misfit - other.refit.misfit) / max(fit.misfit - noise, 1e-12), 1.0)
        change = other.refit.point.coordinates[fit.free] - fit.point.coordinates[fit.free]
        total += mended
        squares += mended * change**2
    return squares / total if total > 0 else squares
