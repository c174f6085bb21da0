"""Effects that leave the same trace in any record: they are answered as one class.

A gain of the force and one of the displacement differ by what the rig's mass and stiffnesses would have to
be, and by nothing that is recorded. What is stated of the rig makes one likelier than another and orders the
class; it is no measurement of today, so that it never leaves one name alone.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

AT_MOST = 0.6
"""No effect has a larger share of its class's probability than this."""


def classes(traces: Mapping[str, Sequence[str]], misfits: Mapping[str, float]) -> dict[str, tuple[str, ...]]:
    """The other effects of every effect's class. `traces`: those of all effects; `misfits`: what the effects
    leave that were refitted. Of an effect with several traces that counts whose other effects come closest to
    the records."""
    found = {}
    for key, own in traces.items():
        sharing = [
            [other for other, theirs in traces.items() if other != key and trace in theirs] for trace in own
        ]
        sharing = [others for others in sharing if others]
        if sharing:
            closest = [min(misfits.get(other, math.inf) for other in others) for others in sharing]
            found[key] = tuple(sharing[closest.index(min(closest))])
    return found


def shared(probabilities: Mapping[str, float], members: Collection[str]) -> dict[str, float]:
    """The probabilities with those of a class's members so mixed with equal ones that none has more than
    `AT_MOST` of what the class has; their order stays."""
    whole, equal = sum(probabilities[key] for key in members), 1 / len(members)
    kept = max(AT_MOST - equal, 0.0) / (1 - equal)
    own = {key: kept * probabilities[key] + (1 - kept) * whole * equal for key in members}
    return {**probabilities, **own}
