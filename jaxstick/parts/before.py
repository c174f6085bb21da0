"""What is known of the time before a motion that is picked up in the middle of a record."""

from __future__ import annotations

import math
from typing import NamedTuple

from jaxstick.parts.motion import Scalar
from jaxstick.parts.track import Trace, Track


class Before(NamedTuple):
    """The time before a start, nothing of it known where the record begins there.

    rest, for how long the contact has held [s]; slid, the sense in which the mass slid last (1, -1, 0: it did
    not, or nobody knows); impulse, the integral of the friction force from the beginning of the run [N s],
    and impulse_sum, the integral of that [N s^2]; recorded, that force as the force channel shows it at the
    start [N], not a number without that channel; shown, what the channel has shown before, and track, where
    mass and base have been, None where nobody knows.
    """

    rest: Scalar = 0.0
    slid: Scalar = 0.0
    impulse: Scalar = 0.0
    impulse_sum: Scalar = 0.0
    recorded: Scalar = math.nan
    shown: Trace | None = None
    track: Track | None = None
