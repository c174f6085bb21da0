"""A mode of motion: between two events one smooth equation holds, and the exits say where it ends."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

OfState = Callable[[float, float, float], float]


class Entry(NamedTuple):
    """A mode and the velocity [m/s] it begins with (corrected for round-off of the event where need be)."""

    mode: "Mode"
    v: float


class Exit(NamedTuple):
    """`value`(t, x, v) is negative in the mode; where it rises to zero `enter`(t, x, v) gives the next."""

    value: OfState
    enter: Callable[[float, float, float], Entry]


@dataclass(frozen=True)
class Mode:
    """`kind` is "stick", "slip+" or "slip-"; `friction` F [N], `deflection` z [m] of the contact spring.

    `acceleration` is to be integrated; where `follow` is given, (x, v) are known as a function of the time
    instead.
    """

    kind: str
    friction: OfState
    deflection: OfState
    exits: tuple[Exit, ...]
    acceleration: OfState
    follow: Callable[[float], tuple[float, float]] | None = None


def slip_name(direction: int) -> str:
    """ "slip+" or "slip-"."""
    return "slip+" if direction > 0 else "slip-"
