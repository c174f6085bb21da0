"""The phases of a stick-slip motion, sample by sample."""

from __future__ import annotations

import numpy as np

AT_REST = 0.02
"""The mass counts as at rest below this share of its top speed."""
AROUND_EVENT = 0.03
"""Breakaway and arrest last this share of a natural period to both sides."""


def phases_of(velocity: np.ndarray, counts: np.ndarray, period: float) -> dict[str, np.ndarray]:
    """Masks of the samples (lanes, samples) in stick, at breakaway, in slip, at arrest; `counts` says which
    samples are real, `period` [samples] is the natural one."""
    resting = np.abs(velocity) < AT_REST * np.max(np.abs(velocity[counts]))
    reach = max(2, round(AROUND_EVENT * period))
    leaves = np.zeros_like(resting)
    comes = np.zeros_like(resting)
    leaves[:, 1:] = resting[:, :-1] & ~resting[:, 1:]
    comes[:, 1:] = ~resting[:, :-1] & resting[:, 1:]
    breakaway, arrest = _around(leaves, reach), _around(comes, reach)
    arrest &= ~breakaway
    event = breakaway | arrest
    return {
        "stick": resting & ~event,
        "breakaway": breakaway,
        "slip": ~resting & ~event,
        "arrest": arrest,
    }


def _around(marks: np.ndarray, reach: int) -> np.ndarray:
    out = marks.copy()
    for shift in range(1, reach + 1):
        out[:, shift:] |= marks[:, :-shift]
        out[:, :-shift] |= marks[:, shift:]
    return out
