"""Which effects share a compiled program: every one that is attached costs, where it is not meant, too, and
so does every program."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from jaxstick.effect import AbstractEffect

GROUP = 8
"""So many effects at most share a program: the more, the fewer programs, and the longer each takes to run."""
FEW = 5
"""So many effects are compiled sooner, and run faster, by themselves than with the whole shelf."""


@dataclasses.dataclass(frozen=True)
class Sharing:
    """The shelf in `groups` of effects that share one program: of one family, a few each."""

    groups: tuple[tuple[str, ...], ...]

    @classmethod
    def of(cls, shelf: Mapping[str, type[AbstractEffect]]) -> Sharing:
        """The groups of a shelf's effects, by their keys."""
        by_family: dict[str, list[str]] = {}
        for key, effect in shelf.items():
            by_family.setdefault(effect.card.family, []).append(key)
        return cls(
            tuple(
                tuple(part.tolist())
                for keys in by_family.values()
                for part in np.array_split(np.array(keys), -(-len(keys) // GROUP))
            )
        )

    @property
    def whole(self) -> tuple[str, ...]:
        """The whole shelf, in the order of its groups."""
        return tuple(key for group in self.groups for key in group)

    def together(self, keys: Collection[str]) -> tuple[str, ...]:
        """These effects and no others, each once and in one order, so that one program serves."""
        return tuple(key for key in self.whole if key in keys)

    def fitted(self, keys: Sequence[str]) -> tuple[str, ...]:
        """What is attached where these effects are fitted: a single one comes with its group, whose program
        serves the screening, too; several come alone, for a program of two effects is compiled soon, and runs
        several times as fast as one of two groups."""
        alone = self.together(keys)
        return next(group for group in self.groups if keys[0] in group) if len(alone) == 1 else alone

    def seen(self, wanted: Collection[str], present: Collection[str]) -> tuple[str, ...]:
        """What is attached to see what effects would do beside those that are `present`: their group where
        all belong to one, no more than these where they are few, and else the whole shelf, for one program
        that shows everything beside anything is compiled sooner than many that show a few."""
        both = self.together([*wanted, *present])
        among = next((group for group in self.groups if {*both} <= {*group}), None)
        return both if {*wanted} <= {*present} else among or (both if len(both) <= FEW else self.whole)
