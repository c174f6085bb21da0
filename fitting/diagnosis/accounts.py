"""What an explanation is judged by."""

from __future__ import annotations

import dataclasses
import math


@dataclasses.dataclass(frozen=True)
class Account:
    """One explanation's account: its effects, misfit, the number of its parameters that all runs share, and
    how many more belong to one run each, of so many runs; by how much steadier it makes friction (logarithm
    of a likelihood ratio), and which of its effects change friction itself. shapes: how many times as much
    as its prior every degree of freedom of the records says of each parameter that gives an effect its
    shape."""

    keys: tuple[str, ...]
    misfit: float
    parameters: int
    of_one_run: float = 0.0
    runs: int = 1
    steadier: float = 0.0
    of_friction: tuple[str, ...] = ()
    shapes: tuple[float, ...] = ()

    def price(self, pieces: float) -> float:
        """What its parameters cost, each by the pieces of evidence that it is found from; what gives an
        effect its shape by what they say of it beyond its prior, since a shape that the records do not tell
        fits nothing (Occam factor; MacKay, Neural Computation 4 (1992) 415, section 2)."""
        apart = self.of_one_run * math.log(max(pieces / self.runs, 1.0))
        untold = sum(max(math.log(pieces) - math.log1p(told * pieces), 0.0) for told in self.shapes)
        return 0.5 * (self.parameters * math.log(pieces) - untold + apart)
