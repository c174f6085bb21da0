"""How the values of one axis of a sweep are written: numbers and ranges, 0.04:1.0:400 or 8,10.325."""

import math

import numpy as np

MOST = 10_000_000
"""Values that one axis may have."""


def values_of(text: str) -> tuple[float, ...]:
    """The values that `text` stands for: items between commas, each a number or a range.

    A range low:high:count is that many values at equal distances, both ends included; with :log behind it at
    equal ratios. A value that comes up again counts once.

    Raises ValueError, its message the end of a sentence on the text.
    """
    found: list[float] = []
    for item in text.split(","):
        found += _range(item) if ":" in item else [_number(item)]
        if len(found) > MOST:
            raise ValueError(f"asks for more than {MOST} values")
    return tuple(dict.fromkeys(found))


def _range(item: str) -> list[float]:
    parts = [part.strip() for part in item.split(":")]
    logarithmic = parts[-1] == "log"
    if logarithmic:
        parts.pop()
    if len(parts) != 3:
        raise ValueError(f"has the range {item.strip()!r}, which is not low:high:count or low:high:count:log")
    low, high = _number(parts[0]), _number(parts[1])
    count = _number(parts[2])
    if count != round(count) or count < 1:
        raise ValueError(f"has a range of {parts[2]} values; a whole number from 1 on is expected")
    if count > MOST:
        raise ValueError(f"asks for more than {MOST} values")
    if count == 1 and low != high:
        raise ValueError(f"has a range from {parts[0]} to {parts[1]} of one value only")
    if not logarithmic:
        return np.linspace(low, high, int(count)).tolist()
    if low <= 0 or high <= 0:
        raise ValueError("has equal ratios between ends that are not both positive")
    return np.geomspace(low, high, int(count)).tolist()


def _number(word: str) -> float:
    try:
        number = float(word)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"has {word.strip()!r}, which is not a finite number")
    return number
