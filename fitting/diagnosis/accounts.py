"""What an explanation is judged by."""

from __future__ import annotations

import dataclasses
import math


@dataclasses.dataclass(frozen=True)
class Account:
    """One explanation's account: its effects, misfit, the number of its parameters that all runs share, and
    how many more belong to one run each, of so many runs; by how much steadier it makes friction (logarithm
    of a likelihood ratio), and which of its effects change friction itself."""

    keys: tuple[str, ...]
    misfit: float
    parameters: int
    of_one_run: float = 0.0
    runs: int = 1
    steadier: float = 0.0
    of_friction: tuple[str, ...] = ()

    def price(self, pieces: float) -> float:
        """What its parameters cost, each by the pieces of evidence that it is found from."""
        apart = self.of_one_run * math.log(max(pieces / self.runs, 1.0))
        return 0.5 * (self.parameters * math.log(pieces) + apart)
