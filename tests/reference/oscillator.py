"""The constants of one oscillator with a rubbing contact, and the forces on its mass but friction."""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, inf, isfinite

from tests.reference.drive import Drive

ForceOnMass = Callable[[float, float, float], float]


@dataclass(frozen=True)
class Oscillator:
    """m x'' + c x' + K x = k_d y + c_d y' + u + extra_force(t, x, x') + F, SI units.

    F is the friction force on the mass. In slip F = -sign(w) [A exp(-B |w|) + C + D |w|] with the sliding
    velocity w = x' ("ground") or w = x' - y' ("base"). `k1` [N/m] is the stiffness of the contact in stick
    (infinite: rigid), `drive_stiffness` k_d is K where it is not given. `extra_force` is any further smooth
    force on the mass.
    """

    mass: float
    stiffness: float
    damping: float
    A: float
    B: float
    C: float
    D: float
    k1: float = inf
    drive_stiffness: float | None = None
    drive_damping: float = 0.0
    friction_against: str = "ground"
    extra_force: ForceOnMass | None = None

    def __post_init__(self) -> None:
        if self.mass <= 0.0 or self.k1 <= 0.0:
            raise ValueError(f"mass and k1 must be positive, not {self.mass} and {self.k1}")
        if min(self.A, self.B, self.C, self.D) < 0.0:
            raise ValueError("A, B, C and D must not be negative")
        if self.friction_against not in ("ground", "base"):
            raise ValueError(f"friction_against is 'ground' or 'base', not {self.friction_against!r}")

    @property
    def static_friction(self) -> float:
        """A + C [N]."""
        return self.A + self.C

    def weakening(self, speed: float) -> float:
        """A exp(-B |w|) [N]; continued smoothly to speed < 0, where stages of a step past w = 0 may look."""
        return self.A * exp(min(-self.B * speed, 30.0))

    def limit(self, speed: float) -> float:
        """g(|w|) = A exp(-B |w|) + C [N]: what the contact spring carries at sliding speed |w| [m/s]."""
        return self.weakening(speed) + self.C

    def sliding_friction(self, direction: int, w: float) -> float:
        """F [N] in slip in `direction` = sign(w)."""
        speed = direction * w
        return -direction * (self.weakening(speed) + self.C + self.D * speed)

    def first_step(self, drive: Drive) -> float:
        """A step [s] short against every time scale of the oscillator, to start a mode with."""
        total = self.stiffness + (self.k1 if isfinite(self.k1) else 0.0)
        own = (self.mass / total) ** 0.5 if total > 0.0 else inf
        return 0.01 * min(own, drive.time_scale)


def other_forces(rig: Oscillator, drive: Drive) -> ForceOnMass:
    """N(t, x, v) = k_d y + c_d y' + u - K x - c v + extra_force [N]: all forces on the mass but friction."""
    k_d = rig.stiffness if rig.drive_stiffness is None else rig.drive_stiffness
    load = drive.load(k_d, rig.drive_damping)
    stiffness, damping, extra = rig.stiffness, rig.damping, rig.extra_force
    if extra is None:
        return lambda t, x, v: load(t) - stiffness * x - damping * v
    return lambda t, x, v: load(t) - stiffness * x - damping * v + extra(t, x, v)
