"""What may explain the records: one effect or several, refitted."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from fitting.diagnosis.refit import Refit
from fitting.diagnosis.screen import Promise


@dataclasses.dataclass(frozen=True)
class Explanation:
    """One effect or several, refitted, with the promise that brought it on the short list."""

    keys: tuple[str, ...]
    promise: Promise
    refit: Refit


def best_of(explanations: Sequence[Explanation]) -> list[Explanation]:
    """Of explanations by the same effects the one with the lowest misfit."""
    best: dict[frozenset[str], Explanation] = {}
    for one in explanations:
        rival = best.get(frozenset(one.keys))
        if rival is None or one.refit.misfit < rival.refit.misfit:
            best[frozenset(one.keys)] = one
    return list(best.values())
