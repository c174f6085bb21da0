"""Random streams by name: the same seed gives development, calibration and judging other cases.

A stream is seeded with the SHA-256 of its family, its seed and what it is for, so that families never meet
whatever seeds are chosen: seed 7 of "judging" has nothing in common with seed 7 of "development".
"""

from __future__ import annotations

import hashlib

import numpy as np

from fitting.blind.kinds import FAMILIES


def stream(family: str, seed: int, *purpose: str | int) -> np.random.Generator:
    """The random numbers of one purpose; raises ValueError for a family that is not one of FAMILIES."""
    if family not in FAMILIES:
        raise ValueError(f"the family is one of {', '.join(FAMILIES)}, not {family!r}")
    name = "/".join(str(part) for part in ("jaxstick blind", family, seed, *purpose))
    return np.random.default_rng(int.from_bytes(hashlib.sha256(name.encode()).digest()))


def seed_checksum(family: str, seed: int) -> str:
    """What may be published of a seed before its cases are opened: SHA-256 of family and seed."""
    return hashlib.sha256(f"jaxstick blind seed {family} {seed}".encode()).hexdigest()
