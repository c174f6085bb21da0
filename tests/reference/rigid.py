"""The rigid contact, k1 -> infinity.

Stick: w = 0, and F balances the other forces while |F| <= A + C. Slip in direction s: F = -s [A exp(-B |w|) +
C + D |w|]. Slip ends where w reaches zero: in stick if the force needed for w' = 0 is within A + C, else in
slip the other way. z is zero throughout.
"""

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
    *,
    tolerance: float = RELATIVE_TOLERANCE,
) -> Run:
    """Motion from (x0, v0) at times[0], read at `times` [s]; k1 of `rig` is not used."""
    contact = _Rigid(rig, drive)
    t0, x0, v0 = float(times[0]), float(x0), float(v0)
    w = v0 - contact.surface.velocity(t0)
    entry = contact.at_rest(t0, x0, v0) if w == 0.0 else Entry(contact.slip(1 if w > 0.0 else -1), v0)
    return march(entry, x0, times, drive, rig.first_step(drive), tolerance)


class _Rigid:
    def __init__(self, rig: Oscillator, drive: Drive) -> None:
        self.rig, self.surface, self.others = rig, surface_of(rig, drive), other_forces(rig, drive)

    def at_rest(self, t: float, x: float, _: float) -> Entry:
        """The mode after w has come to zero."""
        v = self.surface.velocity(t)
        pull = self._pull(t, x, v)
        if abs(pull) <= self.rig.static_friction:
            return Entry(self.stick(t, x), v)
        return Entry(self.slip(1 if pull > 0.0 else -1), v)

    def stick(self, t0: float, x0: float) -> Mode:
        surface, pull, static = self.surface, self._pull, self.rig.static_friction
        place = x0 - surface.position(t0)

        def exit_to(s: int) -> Exit:
            return Exit(
                lambda t, x, v: s * pull(t, x, v) - static,
                lambda t, x, v: Entry(self.slip(s), v),
            )

        return Mode(
            kind="stick",
            friction=lambda t, x, v: -pull(t, x, v),
            deflection=lambda t, x, v: 0.0,
            exits=(exit_to(1), exit_to(-1)),
            acceleration=lambda t, x, v: surface.acceleration(t),
            follow=lambda t: (place + surface.position(t), surface.velocity(t)),
        )

    def slip(self, s: int) -> Mode:
        rig, others, velocity = self.rig, self.others, self.surface.velocity

        def friction(t: float, x: float, v: float) -> float:
            return rig.sliding_friction(s, v - velocity(t))

        return Mode(
            kind=slip_name(s),
            friction=friction,
            deflection=lambda t, x, v: 0.0,
            exits=(Exit(lambda t, x, v: -s * (v - velocity(t)), self.at_rest),),
            acceleration=lambda t, x, v: (others(t, x, v) + friction(t, x, v)) / rig.mass,
        )

    def _pull(self, t: float, x: float, v: float) -> float:
        """The force [N] friction must balance to keep the mass on the surface."""
        return self.others(t, x, v) - self.rig.mass * self.surface.acceleration(t)
