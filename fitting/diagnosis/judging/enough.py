"""How much of a gap an explanation may leave for nothing more to be looked for."""

from __future__ import annotations

SUFFICES = 0.01
NEXT_TO_NOISE = 1.1
"""One effect suffices where it leaves less than this share of the excess, or less than this misfit;"""
HINT = 0.1
"""Two effects are not sought where none takes away as much as this share of the excess alone;"""
NOTHING = 0.001
NOISE = 1.03
"""it leaves nothing to a second one below these."""
NOISE_KNOWN = 0.05
"""Chi-square per degree of freedom may lie so much above 1 because the noise is not known better: as little
is no bias that tells of a wrong model, where effects are compared with none, nor of a second effect."""


def suffices(nominal: float, alone: float) -> bool:
    """Whether one effect leaves so little of the excess that the model needs no other contact."""
    return passes_for_noise(alone) or alone < 1 + SUFFICES * (nominal - 1)


def hints(nominal: float, alone: float) -> bool:
    """Whether the best effect takes away enough of the excess for a second to be sought beside it."""
    return nominal - alone > HINT * (nominal - 1)


def passes_for_noise(misfit: float) -> bool:
    """Whether what an explanation leaves may be noise alone."""
    return misfit < NEXT_TO_NOISE


def leaves_nothing(nominal: float, alone: float) -> bool:
    """Whether one effect leaves so little of the excess that no second one need be sought."""
    return is_nothing_but_noise(alone) or alone < 1 + NOTHING * (nominal - 1)


def is_nothing_but_noise(misfit: float) -> bool:
    """Whether what an explanation leaves says nothing of another effect."""
    return misfit < NOISE
