"""Effects that leave the same trace in any record: they are answered as one class.

A gain of the force and one of the displacement differ by what the rig's mass and stiffnesses would have to
be, and by nothing that is recorded. What is stated of the rig makes one likelier than another and orders the
class; it is no measurement of today, so that it never leaves one name alone.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

AT_MOST = 0.6
"""No effect has a larger share of its class's probability than this."""


Classes = Mapping[tuple[str, ...], tuple[str, ...]]
"""The other effects of an effect's class, by the effect and, behind it, what acts beside it."""


def classes(traces: Mapping[str, Sequence[str]], misfits: Mapping[frozenset[str], float]) -> Classes:
    """The class of every effect that has one, where it acts alone and in every pair that was refitted.

    `traces`: those of all effects; `misfits`: what explanations leave, by their effects. Of an effect with
    several traces that counts whose other effects come closest to the records in its place.
    """
    found = {}
    for key, *beside in [*((key,) for key in traces), *_ordered(misfits)]:
        sharing = [
            [other for other, theirs in traces.items() if other not in (key, *beside) and trace in theirs]
            for trace in traces[key]
        ]
        sharing = [others for others in sharing if others]
        if sharing:
            closest = [
                min(misfits.get(frozenset((other, *beside)), math.inf) for other in others)
                for others in sharing
            ]
            found[key, *beside] = tuple(sharing[closest.index(min(closest))])
    return found


def _ordered(explanations: Collection[frozenset[str]]) -> Iterator[tuple[str, ...]]:
    """Explanations by several effects, with each of them first."""
    for keys in explanations:
        for key in sorted(keys) if len(keys) > 1 else ():
            yield key, *sorted(keys - {key})


def shared(probabilities: Mapping[str, float], members: Collection[str]) -> dict[str, float]:
    """The probabilities with those of a class's members so mixed with equal ones that none has more than
    `AT_MOST` of what the class has; their order stays."""
    whole, equal = sum(probabilities[key] for key in members), 1 / len(members)
    kept = max(AT_MOST - equal, 0.0) / (1 - equal)
    own = {key: kept * probabilities[key] + (1 - kept) * whole * equal for key in members}
    return {**probabilities, **own}
