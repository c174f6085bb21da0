"""One sealed case beside its diagnosis, and the rules by which an answer is right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fitting.blind.menu import FAMILIES, aliases, classes

NONE, UNLISTED = "none", "unlisted"
SINGLE, PAIR = "single", "pair"
MISSING = "no answer"
SEVERAL = "several"
NAMING = ("effect", "several", "ambiguous")
"""The verdicts that name effects."""

EXTRA = 1
"""An ambiguous answer is right with so many effects beside the truth and its exact aliases."""


@dataclass(frozen=True)
class Judged:
    """A case of the set: what it holds (`truth`: effects' keys, or "none", or "unlisted"), and the content of
    its diagnosis.json; None where there is none, which counts as wrong wherever it counts.

    gap: the gap that the effects open over the noise; limit_ratio: the same over the detection limit of an
    ideal observer, None where nobody worked it out. samples: values in the records of the case.
    """

    case: str
    kind: str
    tier: str
    truth: tuple[str, ...]
    gap: float
    limit_ratio: float | None
    samples: int
    answer: Mapping[str, Any]
    result: Mapping[str, Any] | None

    @property
    def verdict(self) -> str:
        """The verdict, or that there is none."""
        return MISSING if self.result is None else self.result["verdict"]

    @property
    def named(self) -> tuple[str, ...]:
        """The effects that the verdict names, the likeliest first."""
        if self.result is None or self.verdict not in NAMING:
            return ()
        return tuple(self.result["named"])

    @property
    def probabilities(self) -> Mapping[str, float]:
        """The probability of every answer; empty without a diagnosis."""
        return {} if self.result is None else self.result["probabilities"]

    @property
    def same(self) -> frozenset[str]:
        """The truth and what leaves the same trace in any records."""
        return frozenset(self.truth).union(*(aliases(key) for key in self.truth))

    def right(self) -> bool:
        """Whether the verdict is the truth.

        One effect: it is named alone, or the answer is ambiguous, holds it and, beyond its exact aliases, at
        most one other. Two: both are named as acting together, or one effect that has the traces of both, and
        no third but for exact aliases.
        """
        if self.kind in (NONE, UNLISTED):
            return self.verdict == self.kind
        if self.kind == PAIR:
            return self.both() and not self.third()
        others = set(self.named) - self.same
        if self.verdict == "effect":
            return self.named == self.truth
        return self.verdict == "ambiguous" and set(self.truth) <= set(self.named) and len(others) <= EXTRA

    def second(self) -> bool:
        """Whether it is right, or at most one answer that is no exact alias is as likely as the truth."""
        if self.right():
            return True
        own = self.probability_exact()
        likelier = [key for key, p in self.probabilities.items() if p >= own and key not in self.same]
        return own > 0 and len(likelier) <= 1

    def probability(self) -> float:
        """The probability of the truth, exact aliases counted as one answer; 0 without a diagnosis."""
        return _sum(self.probabilities, self.same)

    def probability_exact(self) -> float:
        """The probability of the truth itself; of two effects, both together."""
        return _sum(self.probabilities, frozenset(self.truth))

    def likeliest(self) -> frozenset[str]:
        """The likeliest answer with its exact aliases: the class on which the most probability lies."""
        classes = {key: frozenset((key, *aliases(key))) for key in self.probabilities}
        if not classes:
            return frozenset()
        best = max(classes, key=lambda key: (_sum(self.probabilities, classes[key]), self.probabilities[key]))
        return classes[best]

    def confidence(self) -> float:
        """The probability of the likeliest answer."""
        return _sum(self.probabilities, self.likeliest())

    def likeliest_is_right(self) -> bool:
        """Whether the truth is in the likeliest class."""
        return bool(self.likeliest() & frozenset(self.truth))

    def family_right(self) -> bool:
        """Whether the effect named first is of the truth's family, or an exact alias of it."""
        if not self.named:
            return False
        first = self.named[0]
        return first in self.same or FAMILIES.get(first) == FAMILIES.get(self.truth[0])

    def both(self) -> bool:
        """Whether both effects of a pair are named as acting together, or what leaves the traces of both: a
        wrong drive stiffness and a wrong mass are one effect, a gain of y and one of F are two."""
        if self.verdict == SEVERAL:
            return set(self.truth) <= set(self.named)
        return any(set(self.truth) <= set(aliases(key)) for key in self.named)

    def one(self) -> bool:
        """Whether at least one effect of the case is named."""
        return bool(set(self.truth) & set(self.named)) or self.both()

    def third(self) -> bool:
        """Whether an effect is named that is neither there nor an exact alias of one that is."""
        return bool(set(self.named) - self.same)

    def as_class(self) -> bool:
        """Whether the truth is named together with all of a class of exact aliases that it is in."""
        return self.verdict == "ambiguous" and any(
            group <= set(self.named) for key in self.truth for group in classes(key)
        )

    def alone(self) -> bool:
        """Whether one name of a class of exact aliases got the verdict, or more than 0.6, for itself."""
        top = max((self.probabilities.get(key, 0.0) for key in self.same), default=0.0)
        return self.verdict == "effect" or top > 0.6

    def label(self) -> str:
        """The answer in one word: the truth where it is right, else what is named first, or the verdict."""
        if self.kind != PAIR and self.right():
            return self.truth[0]
        if self.verdict in (NONE, UNLISTED, MISSING, SEVERAL) or not self.named:
            return self.verdict
        return self.named[0]


def _sum(probabilities: Mapping[str, float], keys: frozenset[str]) -> float:
    return min(sum(probabilities.get(key, 0.0) for key in keys), 1.0)
