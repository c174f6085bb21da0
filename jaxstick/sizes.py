"""What a unit amounts to on a rig, made of its own scales of force, length and time."""

from __future__ import annotations

import math
import re

_FACTOR = re.compile(r"([A-Za-z1]+)(?:\^(\d+))?")


def size_of(unit: str, force: float, length: float, time: float) -> float:
    """The size of a unit such as "N s^2/m^2" where a force [N], a length [m] and a time [s] set the scale.

    Raises ValueError for a unit that is not made of N, m, s, kg, Hz, rad and 1.
    """
    known = {
        "N": force,
        "m": length,
        "s": time,
        "kg": force * time**2 / length,
        "Hz": 1 / time,
        "rad": 1.0,
        "1": 1.0,
    }

    def product(text: str) -> float:
        factors = [_FACTOR.fullmatch(word) for word in text.split()]
        if any(factor is None or factor[1] not in known for factor in factors):
            raise ValueError(f"the unit {unit!r} is not made of {', '.join(known)}")
        return math.prod(known[factor[1]] ** int(factor[2] or 1) for factor in factors if factor)

    above, _, below = unit.partition("/")
    return product(above) / product(below)
