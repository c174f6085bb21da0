"""What moves the oscillator: the base motion y(t) [m] and the applied force u(t) [N]."""

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, cos, hypot, inf, pi, sin
from typing import Protocol

OfTime = Callable[[float], float]


class Drive(Protocol):
    """Base position, velocity, acceleration and applied force as functions of the time [s].

    `time_scale` [s]: the shortest time in which the drive changes appreciably. `breakpoints`: instants at
    which one of the functions or a derivative of it jumps; there they are taken to be continuous from the
    right.
    """

    @property
    def time_scale(self) -> float: ...

    @property
    def breakpoints(self) -> tuple[float, ...]: ...

    def position(self, t: float) -> float: ...

    def velocity(self, t: float) -> float: ...

    def acceleration(self, t: float) -> float: ...

    def force(self, t: float) -> float: ...

    def load(self, stiffness: float, damping: float) -> OfTime: ...


@dataclass(frozen=True)
class SineDrive:
    """y = Y sin(2 pi f t + phase), u = U sin(2 pi f t + force_phase)."""

    frequency: float
    base_amplitude: float = 0.0
    base_phase: float = 0.0
    force_amplitude: float = 0.0
    force_phase: float = 0.0

    @property
    def period(self) -> float:
        """One cycle [s]."""
        return 1.0 / self.frequency

    @property
    def time_scale(self) -> float:
        """A sixth of a cycle, nearly one radian."""
        return self.period / 6.0

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """None."""
        return ()

    def position(self, t: float) -> float:
        """Base position y [m]."""
        return self.base_amplitude * sin(2.0 * pi * self.frequency * t + self.base_phase)

    def velocity(self, t: float) -> float:
        """Base velocity y' [m/s]."""
        omega = 2.0 * pi * self.frequency
        return self.base_amplitude * omega * cos(omega * t + self.base_phase)

    def acceleration(self, t: float) -> float:
        """Base acceleration y'' [m/s^2]."""
        return -((2.0 * pi * self.frequency) ** 2) * self.position(t)

    def force(self, t: float) -> float:
        """Applied force u [N]."""
        return self.force_amplitude * sin(2.0 * pi * self.frequency * t + self.force_phase)

    def load(self, stiffness: float, damping: float) -> OfTime:
        """k_d y + c_d y' + u [N] as one sine."""
        omega = 2.0 * pi * self.frequency
        s, c = sin(self.base_phase), cos(self.base_phase)
        in_phase = self.base_amplitude * (stiffness * c - damping * omega * s)
        in_phase += self.force_amplitude * cos(self.force_phase)
        quadrature = self.base_amplitude * (stiffness * s + damping * omega * c)
        quadrature += self.force_amplitude * sin(self.force_phase)
        amplitude, phase = hypot(in_phase, quadrature), atan2(quadrature, in_phase)
        return lambda t: amplitude * sin(omega * t + phase)


@dataclass(frozen=True)
class GivenDrive:
    """Arbitrary functions of the time; what is not given is zero. y, y' and y'' must belong together."""

    time_scale: float
    y: OfTime | None = None
    y_rate: OfTime | None = None
    y_acceleration: OfTime | None = None
    u: OfTime | None = None
    breakpoints: tuple[float, ...] = ()

    def position(self, t: float) -> float:
        """Base position y [m]."""
        return 0.0 if self.y is None else self.y(t)

    def velocity(self, t: float) -> float:
        """Base velocity y' [m/s]."""
        return 0.0 if self.y_rate is None else self.y_rate(t)

    def acceleration(self, t: float) -> float:
        """Base acceleration y'' [m/s^2]."""
        return 0.0 if self.y_acceleration is None else self.y_acceleration(t)

    def force(self, t: float) -> float:
        """Applied force u [N]."""
        return 0.0 if self.u is None else self.u(t)

    def load(self, stiffness: float, damping: float) -> OfTime:
        """k_d y + c_d y' + u [N]."""
        return lambda t: stiffness * self.position(t) + damping * self.velocity(t) + self.force(t)


def no_drive() -> GivenDrive:
    """A base at rest and no applied force."""
    return GivenDrive(time_scale=inf)
