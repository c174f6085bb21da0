"""Whether what the nominal model leaves is noise that is larger than it was taken for.

An effect leaves residuals that resemble one another for a while, and scores then vary by more than those of
white residuals do. Noise that is larger than was estimated, or stated, leaves white ones.
"""

from __future__ import annotations

import numpy as np

WORTH = 1.5
"""What white residuals speak against something off the shelf (logarithm of a likelihood ratio)."""
WHITE, COLOURED = 1.2, 1.5
"""Ratios of the variance of scores to that of white residuals between which they cease to be white. Of 162
sealed cases without an effect and without scatter 146 had less than the first, of seven with one off the
shelf that left a misfit of less than 1.4 none had, and two less than the second, 1.45 and 1.49."""
LITTLE, MUCH = 1.2, 1.4
"""Misfits of the nominal model between which they cease to count: noise is not as badly known as that."""


def whiteness(nominal: float, inflation: float) -> float:
    """By how much white residuals speak against an effect off the shelf (logarithm of a likelihood ratio).

    nominal: the misfit without any effect, over the noise; inflation: variance of scores by clusters of lanes
    over that of white residuals.
    """
    white = float(np.interp(inflation, (WHITE, COLOURED), (1.0, 0.0)))
    return WORTH * white * float(np.interp(nominal, (LITTLE, MUCH), (1.0, 0.0)))
