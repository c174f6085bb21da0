"""Single samples that are off, among motion, noise, steps of a converter and jumps of the velocity."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxstick.noise import estimate_noise
from jaxstick.outliers import outliers

TIME = np.arange(1200) / 250
NOISE = 5e-6
MOTION = 5e-3 * np.sin(2 * np.pi * 1.3 * TIME)


def recorded(motion: np.ndarray, seed: int = 0, quantum: float = 1e-7) -> np.ndarray:
    """The motion as a converter with such a step sees it, in digits of a tenth of a micrometre."""
    noisy = motion + NOISE * np.random.default_rng(seed).standard_normal(len(motion))
    return np.round(np.round(noisy / quantum) * quantum, 7)


@given(
    st.sets(st.integers(10, 1189), min_size=1, max_size=12),
    st.sampled_from([-1.0, 1.0]),
    st.floats(2e-4, 2e-2),
    st.integers(0, 50),
)
def test_samples_that_are_off_are_found(places: set[int], sense: float, size: float, seed: int) -> None:
    apart = [place for place in sorted(places) if not {place + k for k in range(1, 9)} & places]
    motion = MOTION.copy()
    motion[apart] += sense * size
    record = recorded(motion, seed)
    found, off = outliers(record, estimate_noise(record))
    assert found.tolist() == apart
    np.testing.assert_allclose(off, sense * size, atol=10 * NOISE)


@pytest.mark.parametrize("quantum", [1e-7, 5.976e-6, 31.3e-6])
@pytest.mark.parametrize(
    "motion",
    [
        MOTION,
        np.full(1200, 1.2345e-3),
        5e-3 * np.abs(np.sin(2 * np.pi * 1.3 * TIME)),
        5e-3 * np.sign(np.sin(2 * np.pi * 1.3 * TIME)),
        np.minimum(MOTION, 3e-3),
    ],
    ids=["sine", "rest", "rebounds", "jumps", "a stop"],
)
def test_no_motion_is_taken_for_one(motion: np.ndarray, quantum: float) -> None:
    """Nor a converter's step now and then, where it is coarse."""
    for seed in range(5):
        record = recorded(motion, seed, quantum)
        assert len(outliers(record, estimate_noise(record))[0]) == 0
