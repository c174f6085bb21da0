"""Whether what two effects leave is evidence for a second one, or for another shape of the first.

The constants are set from what right effects in other formulations left alone, and what the best second
effect made of that, in sealed cases, beside cases that had two.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence

from fitting.diagnosis.accounts import Account
from fitting.diagnosis.judging.enough import NOISE_KNOWN

SHAPE = 0.015
"""The share of the excess that depends on the shape of an effect in any case: what two leave counts against
so much, or against what one leaves by"""
REST = 0.3
"""this factor, where that is less."""
OTHER_SHAPE = 0.015
"""The share of the excess that the right effect may leave because it has another shape than on the shelf,"""
OTHER_SHAPE_OF_LITTLE, LITTLE = 0.1, 0.5
"""or this larger one up to so much above the noise: what a second effect makes of no more than that is no
evidence for it where it is so little and the two are collinear, nor unless one of them leaves hardly more
alone than the best,"""
NEARLY = 2.0
"""no more than so many times as much above the noise, and both together next to nothing of that:"""
MENDED = 0.1
"""at most this share, for what mends a shape mends it in part."""
MENDED_BY_ONE, APART, NOT_LITTLE = 0.5, 1.5, 0.2
"""Or at most this share of more than so much above the noise, where what is left without this second effect,
whatever stands in its place, is so many times as much: a wrong shape is mended a little by several, a second
effect that acts only by itself. In 36 sealed cases with one effect no second one did so, in three of 24 with
two the right one, which was not named for want of this; a contact of another shape left a twelfth above the
noise, and friction at the guide mended most of that."""
HARDLY = 0.002
"""What one effect leaves above the noise is no evidence for a second one where it is a smaller share of the
excess, or less than the noise is known to. Of 1768 sealed cases two that had one effect and
none that had two would be answered otherwise without the latter."""
ALL_BUT, MOST = 0.1, 0.4
"""It is evidence where two leave no more than the former share of it, and the latter is left without this
second effect, whatever stands in its place. Of the same cases two that had two effects, and none with one,
are answered otherwise for that; the same for 0.3 and 0.7. Of 800 more, one that had two is told with 0.3 and
0.4 and not with 0.5, in which an error of the stiffness of 0.1 % takes half of what friction at the guide
does; none with one."""


@dataclasses.dataclass(frozen=True)
class Alone:
    """What effects leave alone: misfits by effect, and the nominal model's; what two leave together; the
    effects that are not told from an effect; and those whose traces are nearly collinear with its own."""

    misfits: Mapping[str, float]
    nominal: float
    together: Mapping[frozenset[str], float]
    same: Mapping[str, Collection[str]]
    collinear: Mapping[str, Collection[str]]

    @classmethod
    def of(
        cls,
        accounts: Sequence[Account],
        nominal: float,
        same: Mapping[str, Collection[str]],
        collinear: Mapping[str, Collection[str]],
    ) -> Alone:
        """What the accounts say."""
        singles = {one.keys[0]: one.misfit for one in accounts if len(one.keys) == 1}
        pairs = {frozenset(two.keys): two.misfit for two in accounts if len(two.keys) == 2}
        return cls(singles, nominal, pairs, same, collinear)

    @property
    def best(self) -> float:
        """What the best of them leaves."""
        return min(self.misfits.values(), default=self.nominal)

    @property
    def soft(self) -> float:
        """What differences between two effects and one count against, besides the misfits themselves."""
        return min(SHAPE * self._excess, REST * self._left)

    def makes_needless(self, two: Account) -> bool:
        """Whether one effect does so well that two are no evidence for a second."""
        if self.best < 1 + NOISE_KNOWN:
            return True
        shape = max(OTHER_SHAPE * self._excess, min(OTHER_SHAPE_OF_LITTLE * self._excess, LITTLE))
        if self.best >= 1 + shape:
            return False
        if self._left < LITTLE and self._are_collinear(two.keys):
            return not self._outdoes_a_needed_one(two)
        return self._mends(frozenset(two.keys), two.misfit)

    def _mends(self, two: frozenset[str], together: float) -> bool:
        """Whether the second of two effects only mends the shape of the first: what they leave `together`."""
        if self.best < 1 + HARDLY * self._excess:
            return together > 1 + ALL_BUT * self._left or self._without(two) <= 1 + MOST * self._left
        nearly = {key for key, misfit in self.misfits.items() if misfit <= 1 + NEARLY * self._left}
        mended = MENDED_BY_ONE if self._stands_apart(two, together) else MENDED
        return not nearly & two or together > 1 + mended * self._left

    def _outdoes_a_needed_one(self, two: Account) -> bool:
        """Whether another second effect, whose traces are not collinear with those of the best alone, is
        evidence for a second, and leaves more than this one does beside the same: where a second is needed
        anyway, it may be the collinear one."""
        first = min(self.misfits, key=self.misfits.__getitem__)
        return first in two.keys and any(
            first in keys
            and two.misfit < misfit
            and not self._are_collinear(keys)
            and not self._mends(keys, misfit)
            for keys, misfit in self.together.items()
        )

    def _are_collinear(self, keys: Collection[str]) -> bool:
        """Whether one of these effects does in part what another of them does."""
        return any(not set(keys).isdisjoint(self.collinear.get(key, ())) for key in keys)

    def _stands_apart(self, two: frozenset[str], together: float) -> bool:
        """Whether far more is left without the second of two, whatever was tried in its place."""
        return self._left >= NOT_LITTLE and self._without(two) - 1 > APART * (together - 1)

    def _without(self, two: frozenset[str]) -> float:
        """What is left without the second of two, whatever was tried in its place; 0 where nothing was."""
        second = max(sorted(two), key=lambda key: self.misfits.get(key, math.inf))
        without = {second, *self.same.get(second, ())}
        others = [misfit for keys, misfit in self.together.items() if not keys & without]
        return min([self.best, *others]) if others else 0.0

    @property
    def _excess(self) -> float:
        return max(self.nominal - 1.0, 0.0)

    @property
    def _left(self) -> float:
        return max(self.best - 1.0, 0.0)
