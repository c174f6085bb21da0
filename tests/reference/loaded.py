"""The contact `loaded`: an elastic-plastic spring with a velocity-dependent limit; z is carried over.

    g(|w|) = A exp(-B |w|) + C
    z' = w              whenever that keeps k1 |z| <= g(|w|), and always while z unloads (w z < 0)
    k1 z = s g(|w|)     otherwise, s = sign(w)
    F = -k1 z in stick (z' = w),   F = -s [g(|w|) + D |w|] in slip

How the definition is turned into events, with s the direction of loading:

- Stick -> slip where s k1 z - g(max(s w, 0)) rises to zero. For s w < 0 the expression is s k1 z - (A + C),
  never positive, so an unloading spring is not clipped even if k1 |z| > g(|w|).
- Slip -> stick where the limit rises faster than z can follow: d(g(|w|)/k1)/dt >= |w|. The limit rises while
  |w| falls, so with A B > 0 this comes shortly before w = 0; the spring then goes on loading with z' = w
  below the limit until w changes sign and unloads it. With A B = 0 the condition is s w <= 0, the arrest
  itself.
- In that condition w' is the acceleration the mass would have in stick (without D |w|). Stick and slip then
  share one boundary, and there is no chatter between them. F jumps by D |w| at both events, and only there.
"""

from math import inf

import numpy as np

from tests.reference.drive import Drive
from tests.reference.march import RELATIVE_TOLERANCE, Run, march
from tests.reference.mode import Entry, Exit, Mode, slip_name
from tests.reference.oscillator import Oscillator, other_forces
from tests.reference.surface import surface_of


def simulate(
    rig: Oscillator,
    drive: Drive,
    times: np.ndarray,
    x0: float = 0.0,
    v0: float = 0.0,
    z0: float = 0.0,
    *,
    tolerance: float = RELATIVE_TOLERANCE,
) -> Run:
    """Motion from (x0, v0, z0) at times[0], read at `times` [s].

    A z0 that loads beyond g(|w|) is brought back to the limit, in slip; ValueError where k1 |z0| > A + C.
    """
    if rig.k1 == inf:
        raise ValueError("the contact `loaded` needs a finite k1; use rigid.simulate")
    if rig.k1 * abs(z0) > rig.static_friction:
        raise ValueError(f"k1 |z0| = {rig.k1 * abs(z0)} N is above A + C = {rig.static_friction} N")
    contact = _Loaded(rig, drive)
    t0, x0, v0, z0 = float(times[0]), float(x0), float(v0), float(z0)
    w = v0 - contact.surface.velocity(t0)
    if w * z0 > 0.0 and rig.k1 * abs(z0) >= rig.limit(abs(w)):
        mode = contact.slip(1 if w > 0.0 else -1)
    else:
        mode = contact.stick(t0, x0, z0)
    return march(Entry(mode, v0), x0, times, drive, rig.first_step(drive), tolerance)


class _Loaded:
    def __init__(self, rig: Oscillator, drive: Drive) -> None:
        self.rig, self.surface, self.others = rig, surface_of(rig, drive), other_forces(rig, drive)

    def stick(self, t0: float, x0: float, z0: float) -> Mode:
        rig, others = self.rig, self.others
        k1, mass, position, velocity = rig.k1, rig.mass, self.surface.position, self.surface.velocity
        unstressed = x0 - position(t0) - z0

        def deflection(t: float, x: float, _: float) -> float:
            return x - position(t) - unstressed

        def exit_to(s: int) -> Exit:
            return Exit(
                lambda t, x, v: s * k1 * deflection(t, x, v) - rig.limit(max(s * (v - velocity(t)), 0.0)),
                lambda t, x, v: Entry(self.slip(s), v),
            )

        return Mode(
            kind="stick",
            friction=lambda t, x, v: -k1 * deflection(t, x, v),
            deflection=deflection,
            exits=(exit_to(1), exit_to(-1)),
            acceleration=lambda t, x, v: (others(t, x, v) - k1 * (x - position(t) - unstressed)) / mass,
        )

    def slip(self, s: int) -> Mode:
        rig, others, surface = self.rig, self.others, self.surface
        B, C, D, k1, mass, velocity = rig.B, rig.C, rig.D, rig.k1, rig.mass, surface.velocity

        def deflection(t: float, _: float, v: float) -> float:
            return s * rig.limit(s * (v - velocity(t))) / k1

        def outpaced(t: float, x: float, v: float) -> float:
            speed = s * (v - velocity(t))
            weakening = rig.weakening(speed)
            rate_of_speed = s * ((others(t, x, v) - s * (weakening + C)) / mass - surface.acceleration(t))
            return -B * weakening * rate_of_speed / k1 - speed

        def acceleration(t: float, x: float, v: float) -> float:
            speed = s * (v - velocity(t))
            return (others(t, x, v) - s * (rig.weakening(speed) + C + D * speed)) / mass

        return Mode(
            kind=slip_name(s),
            friction=lambda t, x, v: rig.sliding_friction(s, v - velocity(t)),
            deflection=deflection,
            exits=(Exit(outpaced, lambda t, x, v: Entry(self.stick(t, x, deflection(t, x, v)), v)),),
            acceleration=acceleration,
        )
