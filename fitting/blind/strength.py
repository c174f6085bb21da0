"""How strongly an effect acts: so that the gap it opens has the size that was drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fitting.blind.formulation import Formulation, between
from fitting.blind.gap import Gap, detection_limit, gap
from fitting.blind.menu import HIDDEN_BY_RIG
from fitting.blind.recipe import Chosen, Recipe
from fitting.blind.scales import Scales

TIMES = {"strong": (3.0, 30.0), "weak": (0.5, 8.0)}
"""Between how many times what the gap lies: the noise for strong effects, the detection limit for weak."""

EVALUATIONS = 6
CLOSE = 1.2
"""A gap within this factor of the one drawn is taken."""


@dataclass(frozen=True)
class Sized:
    """An effect with the strength found, the gap it opens alone, and the one that was wanted."""

    chosen: Chosen
    gap: Gap
    wanted: float

    @property
    def reached(self) -> float:
        """The gap that counts for this effect."""
        return relevant(self.chosen.key, self.gap)


def relevant(key: str, opened: Gap) -> float:
    """The gap with a free rig, or with the rig as stated for what a free rig would swallow."""
    return opened.fixed_rig if key in HIDDEN_BY_RIG else opened.free_rig


def size_effect(
    recipe: Recipe,
    scales: Scales,
    effect: Formulation,
    mode: str,
    random: np.random.Generator,
) -> Sized:
    """Draws the shape and the gap, and finds the strength by iteration in proportion, within sensible bounds.

    Strong: a gap of 3 to 30 times the noise. Weak: half to eight times the detection limit; an effect with a
    least strength (hidden below it by what is known of the rig) has half to eight times that strength's half.
    """
    shape = effect.shape(scales, random)
    sign = -1.0 if effect.signed and random.random() < 0.5 else 1.0
    least, most = effect.least(scales), effect.most(scales)
    fixed = mode == "weak" and least > 0.0
    wanted = between(random, *TIMES[mode])
    strength = 0.5 * least * wanted if fixed else float(np.clip(effect.typical(scales), least, most))
    if mode == "weak":
        least, wanted = 0.0, wanted * detection_limit(recipe)
    best: Sized | None = None
    tried: list[tuple[float, float]] = []
    for _ in range(EVALUATIONS):
        chosen = Chosen(key=effect.key, version=effect.version, strength=sign * strength, shape=shape)
        opened = gap(replace(recipe, effects=(chosen,)), (chosen,), scales)
        sized = Sized(chosen, opened, wanted)
        if best is None or _miss(sized) < _miss(best):
            best = sized
        tried.append((strength, sized.reached / wanted))
        new = float(np.clip(_next(tried), least, most))
        if fixed or 1.0 / CLOSE < sized.reached / wanted < CLOSE or new == strength:
            break
        strength = new
    assert best is not None
    return best


def _next(tried: list[tuple[float, float]]) -> float:
    """The strength to try next: between the nearest too weak and too strong, or in proportion.

    tried: strengths with the gaps they opened, in units of the gap wanted.
    """
    weak = max((one for one in tried if one[1] < 1.0), default=None)
    strong = min((one for one in tried if one[1] >= 1.0), default=None)
    if weak and strong and weak[0] < strong[0]:
        low, high = (np.log(max(one[1], 1e-3)) for one in (weak, strong))
        share = float(np.clip(-low / (high - low), 0.1, 0.9)) if high > low else 0.5
        return float(weak[0] * (strong[0] / weak[0]) ** share)
    strength, opened = tried[-1]
    return strength * float(np.clip(1.0 / max(opened, 1e-3), 0.03, 8.0))


def _miss(sized: Sized) -> float:
    if not np.isfinite(sized.reached):
        return np.inf
    return abs(float(np.log(max(sized.reached, 1e-9) / sized.wanted)))
