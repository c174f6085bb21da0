"""What is large and small on one rig: the sizes by which effects and noise are drawn."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Scales:
    """Sizes of a rig's motion without effects, SI.

    period: natural period; stroke, speed: median over the runs of half the range of x and of the largest
    |x'|; reach, haste: the same for the largest run; base: median base amplitude; force: A + C; stick:
    deflection at which the contact yields; weakening: speed 1/B; interval: between samples; duration: of
    the longest run; lowest: drive frequency.
    """

    mass: float
    stiffness: float
    damping: float
    period: float
    stroke: float
    speed: float
    reach: float
    haste: float
    base: float
    force: float
    stick: float
    weakening: float
    ring_damping: float
    interval: float
    duration: float
    lowest: float

    @property
    def acceleration(self) -> float:
        """What the friction force gives the mass [m/s^2]."""
        return self.force / self.mass
