"""What a part sees of the world at one instant."""

from __future__ import annotations

from typing import NamedTuple

from jaxtyping import Array, Float

from jaxstick.parts.track import Stick, Track

Scalar = Float[Array, ""] | float


class Motion(NamedTuple):
    """The motion of the mass, of the base and of the rubbing surfaces at one time.

    t time [s]; x, v, a displacement, velocity and acceleration of the mass [m, m/s, m/s^2]; y, y_rate,
    y_acceleration those of the base; u applied force [N]; slide displacement of the mass over the surface it
    rubs on [m], slide_rate its rate [m/s]; direction the sense in which the contact is loaded, +1 or -1.
    At the beginning alone: slid, the sense in which the mass slid last, 0 where it did not or that is not
    known; track, where it has been, and stick, what holds it, None where that is not known.
    """

    t: Scalar
    x: Scalar
    v: Scalar
    a: Scalar
    y: Scalar
    y_rate: Scalar
    y_acceleration: Scalar
    u: Scalar
    slide: Scalar
    slide_rate: Scalar
    direction: Scalar
    slid: Scalar = 0.0
    track: Track | None = None
    stick: Stick | None = None
