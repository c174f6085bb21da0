"""What an explanation is judged by."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable


@dataclasses.dataclass(frozen=True)
class Account:
    """One explanation's account: its effects, misfit, the number of its parameters that all runs share, and
    how many more belong to one run each, of so many runs; by how much steadier it makes friction (logarithm
    of a likelihood ratio), and which of its effects change friction itself. shapes: how many times as much
    as its prior every degree of freedom of the records says of each parameter that gives an effect its
    shape. changing: which of its effects change along the runs."""

    keys: tuple[str, ...]
    misfit: float
    parameters: int
    of_one_run: float = 0.0
    runs: int = 1
    steadier: float = 0.0
    of_friction: tuple[str, ...] = ()
    shapes: tuple[float, ...] = ()
    changing: tuple[str, ...] = ()

    def price(self, pieces: float) -> float:
        """What its parameters cost, each by the pieces of evidence that it is found from; what gives an
        effect its shape by what they say of it beyond its prior, since a shape that the records do not tell
        fits nothing (Occam factor; MacKay, Neural Computation 4 (1992) 415, section 2)."""
        apart = self.of_one_run * math.log(max(pieces / self.runs, 1.0))
        untold = sum(max(math.log(pieces) - math.log1p(told * pieces), 0.0) for told in self.shapes)
        return 0.5 * (self.parameters * math.log(pieces) - untold + apart)


def within_scatter(accounts: Iterable[Account]) -> tuple[Account, ...]:
    """The accounts where residuals are weighed by what does not repeat itself, which is known from the
    records alone: a second effect earns nothing by leaving less than that, and pays nothing for it where one
    leaves less still."""
    accounts = tuple(accounts)
    least = min([1.0, *(one.misfit for one in accounts if len(one.keys) == 1)])
    return tuple(
        one if len(one.keys) == 1 else dataclasses.replace(one, misfit=max(one.misfit, least))
        for one in accounts
    )
