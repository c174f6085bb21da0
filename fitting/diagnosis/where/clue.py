"""What an engineer may go by where no effect on the shelf explains the records: what the gap follows.

Every pattern has a clause, behind "lacks a force that" or "differs by what", and says where to look.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import NamedTuple

from fitting.diagnosis.findings import Patterns

NOTABLE, SURELY = 0.1, 3.0
"""A side lacks something whose excess is more than this, and so many standard deviations above zero,"""
FEWEST_APART = 3
"""or of which so many segments fit far worse than the rest."""
FOLLOWS, MOSTLY = 0.3, 0.7
"""It follows a pattern that foretells so much of the excess, and comes in moments that have so much of it."""
AS_GOOD = 0.1
"""Of patterns whose shares differ by less than this the plainer one is said."""

MECHANICS, FRICTION, MOTION = "mechanics", "friction", "motion"
"""The sides: the equation of motion closed with the measured friction force; that force where the mass
slides; and the motion where no friction force was recorded."""


BEAT, MOMENTS = "beat", "moments"
"""What oscillates at a frequency of its own, and what comes in moments."""


class Words(NamedTuple):
    """What follows a pattern does, and where to look for it."""

    does: str
    look: str


PATTERNS = {
    BEAT: Words(
        "oscillates at {beat:.4g} Hz whatever the frequency of the drive",
        "Look for what rotates, or rings, at {beat:.4g} Hz: gears, motors, a frame or a lateral mode; record "
        "its vibration beside the motion",
    ),
    "place": Words(
        "depends on the place",
        "Look at the track, the springs and the cables where the residual force over displacement is "
        "largest: a notch, a magnet, something that touches",
    ),
    "speed": Words(
        "depends on the speed",
        "Measure the friction force at constant speeds, and look for dampers, seals and air that brake the "
        "mass",
    ),
    "speeding up": Words(
        "differs between speeding up and slowing down",
        "Compare the force at the same speed while the mass speeds up and slows down: memory of friction, "
        "mass that moves along, a sensor that lags",
    ),
    "along the runs": Words(
        "grows or shrinks along the runs",
        "Record the same run cold and warm: something warms up, wears or works loose, or two clocks run "
        "apart",
    ),
    "speed, one way": Words(
        "acts the same way whichever way the mass moves",
        "Turn the rig, or let it run the other way round: flow, a cable that drags, a load that shifts",
    ),
    "against the motion, by place": Words(
        "acts against the motion and depends on the place",
        "Look along the track for a second contact: a guide, a seal, a cable that rubs",
    ),
    "with the drive": Words(
        "repeats itself with the drive, but follows neither place nor speed alone",
        "Record what really moves the base, with its harmonics and sideways motion, and modes of the rig "
        "that these harmonics excite",
    ),
    MOMENTS: Words(
        "comes in moments",
        "Look at the samples where it is largest: impacts, particles in the contact, or values that a "
        "converter lost or held",
    ),
}
"""The plainer ones first."""
LACKS = {
    MECHANICS: "closed with the measured friction force, the equation of motion lacks a force that",
    FRICTION: "where the mass slides, the measured friction force differs from the model by what",
    MOTION: "the motion lacks a force that",
}


@dataclasses.dataclass(frozen=True)
class Clue:
    """What the gap follows: the side, the pattern, its share of the excess, and the frequency of a beat."""

    side: str
    pattern: str
    share: float
    beat: float | None

    @property
    def clause(self) -> str:
        """What is seen, as a part of a sentence."""
        does = PATTERNS[self.pattern].does.format(beat=self.beat)
        return f"{LACKS[self.side]} {does} ({100 * self.share:.0f} % of it)"

    @property
    def note(self) -> str:
        """What is seen, as a sentence."""
        return f"{self.clause[:1].upper()}{self.clause[1:]}."

    @property
    def sides(self) -> dict[str, float] | None:
        """The excess by mechanics, friction and measurement, as the clue has it: a force that the mass feels
        and the force sensor does not is one of the mechanics, but what comes in moments may as well be a
        fault of a sensor. None where the friction force was not recorded, for nothing is known then."""
        if self.side == MOTION:
            return None
        if self.side == FRICTION:
            return {"mechanics": 0.0, "friction": 1.0, "measurement": 0.0}
        sensor = 0.5 if self.pattern == MOMENTS else 0.0
        return {"mechanics": 1 - sensor, "friction": 0.0, "measurement": sensor}

    @property
    def look(self) -> str:
        """Where to look for it, as a sentence."""
        return f"{PATTERNS[self.pattern].look.format(beat=self.beat)}."


def clue_of(patterns: Mapping[str, Patterns]) -> Clue | None:
    """The clue by side; what the mechanics lack comes first, since friction then differs for its sake as
    well. None where no side lacks anything that follows a pattern."""
    for side in (MECHANICS, MOTION, FRICTION):
        found = patterns.get(side)
        if found is not None and (clue := _followed(side, found)) is not None:
            return clue
    return None


def _followed(side: str, found: Patterns) -> Clue | None:
    lacks = found.excess > NOTABLE and found.significance > SURELY
    shares = dict(found.shares) if lacks else {}
    moments = shares.pop(MOMENTS, found.shares.get(MOMENTS, 0.0))
    best = max(shares.values(), default=0.0)
    if best >= FOLLOWS:
        pattern = next(name for name in PATTERNS if shares.get(name, 0.0) > best - AS_GOOD)
        return Clue(side, pattern, shares[pattern], found.beat)
    if (lacks or found.apart >= FEWEST_APART) and moments >= MOSTLY:
        return Clue(side, MOMENTS, moments, found.beat)
    return None
