"""How strong an effect has to be for a data set to show it."""

from __future__ import annotations

import math

import numpy as np

from fitting.diagnosis.findings import Limit
from fitting.diagnosis.judging.judge import LEAST_INFLATION
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.which.screen import Promise, Screen

DETECTED = 18.0
"""The fall of chi-square that pays for an effect among many."""
NINE_IN_TEN = 1.28


def detection_limit(model: Model, promise: Promise, inflation: float) -> float:
    """The strength [own unit] that lowers chi-square by `DETECTED` in nine of ten data sets like this; of
    several strengths it is that of the first."""
    scale = model.members[model.index(model.shelf.strengths[promise.key][0])[0]].scale
    return float(_shares(promise, inflation)[0]) * scale


def limits(model: Model, seen: Screen, inflation: float) -> tuple[Limit, ...]:
    """The detection limit of every strength of every effect that was screened, in its usual shape."""
    found = []
    for place, promise in enumerate(seen.usual):
        others = np.delete(np.arange(len(seen.keys)), place)
        cosines = seen.cosine[place, others]
        alike = int(others[np.argmax(cosines)]) if cosines.max(initial=0.0) > 0 else None
        names = model.shelf.strengths[promise.key]
        for name, share in zip(names, _shares(promise, inflation).tolist(), strict=True):
            index = int(model.index(name)[0])
            member = model.members[index]
            most = max(-model.lower[index], model.upper[index])
            found.append(
                Limit(
                    effect=promise.key,
                    strength=name.partition(".")[2],
                    value=share * member.scale if share <= most else math.inf,
                    unit=member.unit,
                    likest=None if alike is None else seen.keys[alike],
                    cosine=None if alike is None else float(seen.cosine[place, alike]),
                )
            )
    return tuple(found)


def _shares(promise: Promise, inflation: float) -> np.ndarray:
    """The limit of every strength, the effect's other ones at null, as shares of typical sizes.

    (sqrt(DETECTED) + 1.28) sqrt(inflation/information): the score test's power, where the variance of scores
    is `inflation` times that of white residuals, and at least as many times as the judge takes it to be.
    """
    spread = np.sqrt(max(inflation, LEAST_INFLATION) / np.maximum(promise.information, 1e-300))
    return (math.sqrt(DETECTED) + NINE_IN_TEN) * spread
