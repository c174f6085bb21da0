"""Single samples of a record that no motion explains: bit errors of a converter, a loose plug, a lost word.

A sample that is off by s puts s [1, -4, 6, -4, 1] into the differences of order four about it, to which a
well sampled motion contributes next to nothing; a jump of the velocity, as at a hard stop, contributes in the
ratio [1, -2, 1], which is 0.976 alike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FAR = 20.0
"""So many times the noise off is far."""
ALIKE = 0.99
"""So alike (cosine) have the differences to be to those of a sample that is off."""
OF_MOTION = ("displacement", "base")
"""The channels for which that holds: a force has edges of its own."""
_PATTERN = np.array([1.0, -4.0, 6.0, -4.0, 1.0])


def outliers(signal: NDArray[np.float64], noise: float) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """The numbers of single samples that are off, and by how much, of a uniformly sampled signal of at least
    nine samples (samples,) with noise of that standard deviation. The four samples at either end are not
    judged."""
    about = np.lib.stride_tricks.sliding_window_view(np.diff(signal, 4), len(_PATTERN))
    off = about @ _PATTERN / (_PATTERN @ _PATTERN)
    size = np.linalg.norm(about, axis=1) / np.linalg.norm(_PATTERN)
    far = np.abs(off) > np.maximum(FAR * noise, ALIKE * size)
    found = np.flatnonzero(far)
    return found + 4, off[found]
