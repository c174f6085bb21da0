"""How strong an effect has to be for a data set to show it."""

from __future__ import annotations

import math

from fitting.diagnosis.judge import LEAST_INFLATION
from fitting.diagnosis.model import Model
from fitting.diagnosis.screen import Promise

DETECTED = 18.0
"""The fall of chi-square that pays for an effect among many."""
NINE_IN_TEN = 1.28


def detection_limit(model: Model, promise: Promise, inflation: float) -> float:
    """The strength [own unit] that lowers chi-square by `DETECTED` in nine of ten data sets like this.

    (sqrt(DETECTED) + 1.28) sqrt(inflation/information): the score test's power, where the variance of scores
    is `inflation` times that of white residuals, and at least as many times as the judge takes it to be. Of
    several strengths it is that of the first.
    """
    member = model.members[model.index(model.shelf.strengths[promise.key][0])[0]]
    spread = math.sqrt(max(inflation, LEAST_INFLATION) / max(float(promise.information[0]), 1e-300))
    return (math.sqrt(DETECTED) + NINE_IN_TEN) * spread * member.scale
