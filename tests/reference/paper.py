"""The contact `paper`: equations (3) and (4) of the 1987 paper taken literally.

Where the sliding velocity w changes sign in slip, x_stop = x: z and F restart from zero. Stick while k1 |z| <
A + C (not g): F = -k1 z, z the slide since x_stop. Beyond it slip with F = -sign(w) [A exp(-B |w|) + C + D
|w|] in the direction of the load, until w changes sign. F therefore jumps at both events. In slip z is given
as sign(w) g(|w|)/k1.
"""

from math import inf

import numpy as np

from tests.reference.drive import Drive
from tests.reference.march import RELATIVE_TOLERANCE, Run, march
from tests.reference.mode import Entry, Exit, Mode, slip_name
from tests.reference.oscillator import Oscillator, other_forces
from tests.reference.surface import surface_of

AT_REST = 1e-6
"""|w| [m/s] below which the paper calls the mass at rest."""


def simulate(
    rig: Oscillator,
    drive: Drive,
    times: np.ndarray,
    x0: float = 0.0,
    v0: float = 0.0,
    z0: float | None = None,
    *,
    tolerance: float = RELATIVE_TOLERANCE,
) -> Run:
    """Motion from (x0, v0) at times[0], read at `times` [s].

    It begins in stick with the deflection z0 where that is given, else in stick with z = 0 where |w| < 1e-6
    m/s, else in slip. ValueError where k1 |z0| >= A + C.
    """
    if rig.k1 == inf:
        raise ValueError("the contact `paper` needs a finite k1; use rigid.simulate")
    if z0 is not None and rig.k1 * abs(z0) >= rig.static_friction:
        raise ValueError(f"k1 |z0| = {rig.k1 * abs(z0)} N is not below A + C = {rig.static_friction} N")
    contact = _Paper(rig, drive)
    t0, x0, v0 = float(times[0]), float(x0), float(v0)
    w = v0 - contact.surface.velocity(t0)
    if z0 is None and abs(w) >= AT_REST:
        mode = contact.slip(1 if w > 0.0 else -1)
    else:
        mode = contact.stick(t0, x0, float(z0 or 0.0))
    return march(Entry(mode, v0), x0, times, drive, rig.first_step(drive), tolerance)


class _Paper:
    def __init__(self, rig: Oscillator, drive: Drive) -> None:
        self.rig, self.surface, self.others = rig, surface_of(rig, drive), other_forces(rig, drive)

    def stick(self, t0: float, x0: float, z0: float) -> Mode:
        rig, others, position, k1 = self.rig, self.others, self.surface.position, self.rig.k1
        x_stop = x0 - position(t0) - z0

        def friction(t: float, x: float, _: float) -> float:
            return -k1 * (x - position(t) - x_stop)

        def exit_to(s: int) -> Exit:
            return Exit(
                lambda t, x, v: -s * friction(t, x, v) - rig.static_friction,
                lambda t, x, v: Entry(self.slip(s), v),
            )

        return Mode(
            kind="stick",
            friction=friction,
            deflection=lambda t, x, v: x - position(t) - x_stop,
            exits=(exit_to(1), exit_to(-1)),
            acceleration=lambda t, x, v: (others(t, x, v) + friction(t, x, v)) / rig.mass,
        )

    def slip(self, s: int) -> Mode:
        rig, others, velocity = self.rig, self.others, self.surface.velocity

        def friction(t: float, x: float, v: float) -> float:
            return rig.sliding_friction(s, v - velocity(t))

        return Mode(
            kind=slip_name(s),
            friction=friction,
            deflection=lambda t, x, v: s * rig.limit(abs(v - velocity(t))) / rig.k1,
            exits=(
                Exit(
                    lambda t, x, v: -s * (v - velocity(t)),
                    lambda t, x, v: Entry(self.stick(t, x, 0.0), v),
                ),
            ),
            acceleration=lambda t, x, v: (others(t, x, v) + friction(t, x, v)) / rig.mass,
        )
