"""What may explain the records: one effect or several, refitted."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.which.screen import Promise


@dataclasses.dataclass(frozen=True)
class Explanation:
    """One effect or several, refitted, with the promise that brought it on the short list."""

    keys: tuple[str, ...]
    promise: Promise
    refit: Refit

    def fitted(self, refit: Refit) -> Explanation:
        """The same effects, fitted otherwise."""
        return dataclasses.replace(self, refit=refit)


def best_of(explanations: Sequence[Explanation]) -> list[Explanation]:
    """Of explanations by the same effects the one with the lowest misfit; the best first."""
    best: dict[frozenset[str], Explanation] = {}
    for one in explanations:
        rival = best.get(frozenset(one.keys))
        if rival is None or one.refit.misfit < rival.refit.misfit:
            best[frozenset(one.keys)] = one
    return sorted(best.values(), key=lambda one: one.refit.misfit)


def fitted_again(model: Model, bench: Bench, explanations: Sequence[Explanation]) -> list[Explanation]:
    """Explanations fitted to a bench from where they stand, in the same order."""
    fits = refit(model, bench, [e.refit.point for e in explanations], [e.refit.free for e in explanations])
    return [e.fitted(fit) for e, fit in zip(explanations, fits, strict=True)]
