"""Random processes of unit variance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter


def remembering(white: NDArray[np.float64], correlation: float) -> NDArray[np.float64]:
    """Noise whose neighbouring samples correlate by `correlation`, from white noise of unit variance."""
    kick = np.sqrt(1.0 - correlation**2)
    return lfilter([kick], [1.0, -correlation], white, zi=[(1.0 - kick) * white[0]])[0]


def coloured(
    random: np.random.Generator, count: int, correlation: float, slow: float, memory: float = 0.98
) -> NDArray[np.float64]:
    """Noise of unit variance, of which a share `slow` wanders with the correlation `memory`."""
    fast = remembering(random.standard_normal(count), correlation)
    wander = remembering(random.standard_normal(count), memory)
    return np.sqrt(1.0 - slow) * fast + np.sqrt(slow) * wander
