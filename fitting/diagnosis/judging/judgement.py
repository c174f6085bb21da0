"""What a judgement says: probabilities, a verdict, and what it names."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Mapping

from fitting.diagnosis.findings import Verdict
from fitting.diagnosis.judging.one_class import Classes, shared
from fitting.diagnosis.judging.verdict import UNLISTED, verdict_of

DOUBT = 0.03
"""What is kept for explanations that nobody thought of, effects that were not refitted among them: no
probability is called certain, and none nought. Of 39 sealed cases in which one was taken for all but certain
(0.996), four were wrong. Half of it is kept for "unlisted": of six wrong ones among 328 cases that were as
sure of another answer, four were of effects off the shelf."""


@dataclasses.dataclass(frozen=True)
class Judgement:
    """Probabilities of explanations (by their keys joined with +), of "none" and "unlisted"; those of single
    effects, a pair's shared between its two and a named one's with its class; the verdict and what it names:
    of "several" first the two that act together, then what may act in the place of one of them; what it
    counted for an explanation, by its effects, that friction is steadier under it, for none of the shelf by
    (); and the classes of effects that no record tells apart."""

    explanations: Mapping[str, float]
    effects: Mapping[str, float]
    verdict: Verdict
    named: tuple[str, ...]
    steadier: Mapping[tuple[str, ...], float]
    classes: Classes

    @property
    def taken(self) -> tuple[str, ...]:
        """What the verdict rests on: of "several" the two that act together, else the likeliest; empty where
        nothing is named."""
        return _taken(self.verdict, self.named)

    @property
    def same(self) -> tuple[tuple[str, ...], ...]:
        """For each of what is taken that no record tells from others: it, and these as they are named."""
        found = _same(self.taken, self.classes)
        return tuple(
            (key, *(other for other in self.named if other in others)) for key, others in found.items()
        )


def judged(
    explanations: Mapping[str, float],
    names: Iterable[str],
    steadier: Mapping[tuple[str, ...], float],
    classes: Classes,
) -> Judgement:
    """The judgement that probabilities of explanations come to: those of all names, that of two effects
    shared between them, and the verdict, in which one effect stands for its class."""
    effects = dict.fromkeys(names, 0.0)
    for explanation, p in explanations.items():
        keys = explanation.split("+")
        for key in keys:
            effects[key] += p / len(keys)
    verdict, named = verdict_of(explanations, classes)
    taken, others = _taken(verdict, named), list[str]()
    for key, same in _same(taken, classes).items():
        effects = shared(effects, (key, *same))
        others += sorted(same, key=lambda other: -effects[other])
    if others and verdict == "effect":
        verdict = "ambiguous"
    named = tuple(dict.fromkeys((*taken, *others, *named)))
    return Judgement(explanations, effects, verdict, named, steadier, classes)


def _taken(verdict: Verdict, named: tuple[str, ...]) -> tuple[str, ...]:
    return named[: 2 if verdict == "several" else 1]


def _same(taken: tuple[str, ...], classes: Classes) -> dict[str, tuple[str, ...]]:
    """The others in the class of each of these effects, which act together, where it has one."""
    found = {key: classes.get((key, *(other for other in taken if other != key)), ()) for key in taken}
    return {key: others for key, others in found.items() if others}


def reserve(names: Collection[str]) -> dict[str, float]:
    """What every explanation has of the probability that is kept for those that nobody thought of."""
    kept = dict.fromkeys(names, DOUBT / 2 / (len(names) - 1))
    return {**kept, UNLISTED: DOUBT / 2}
