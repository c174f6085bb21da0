"""Cases small enough to be made by the hundred."""

from __future__ import annotations

from fitting.blind.case import Assignment, Settings, draw_case
from fitting.blind.recipe import Recipe
from fitting.blind.rigs import Size, draw_rig
from fitting.blind.scales import Scales
from fitting.blind.seeds import stream

TINY = Size(runs=2, samples=600)
SETTINGS = Settings("development", 20, TINY)


def tiny_rig(number: int = 1, tier: str = "A") -> tuple[Recipe, Scales]:
    """A rig without effects that sticks and slips in two short runs."""
    return draw_rig(stream("development", number, "tiny rig", tier), tier, TINY)


def tiny_case(kind: str, *keys: str, tier: str = "A", number: int = 1):
    """The recipe and the answer of a small case."""
    return draw_case(SETTINGS, number, Assignment(kind, tier, keys))
