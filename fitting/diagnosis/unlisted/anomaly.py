"""What no effect on the shelf does, and how it is said."""

from __future__ import annotations

import abc

from fitting.diagnosis.findings import Shares


class AbstractAnomaly(abc.ABC):
    """A way in which records are off that no effect on the shelf has: where it is seen, what explains most of
    the gap is not all that acts, and no gap does not mean that nothing does.

    A finder per anomaly (`bursts`, `held_samples`, `jumps`, `own_beat`, `trend_of`, ..) says whether it is
    there.
    """

    @property
    @abc.abstractmethod
    def clause(self) -> str:
        """What is seen, as the verdict says it behind a colon."""

    @property
    @abc.abstractmethod
    def look(self) -> str:
        """What to record or to try next, as a sentence."""

    @property
    def side(self) -> str | None:
        """Where it lies: mechanics, friction or measurement; None where it may be any."""
        return None

    @property
    def sides(self) -> Shares | None:
        """The excess by side, as this has it; None where it may lie on any."""
        if self.side is None:
            return None
        return {name: float(name == self.side) for name in ("mechanics", "friction", "measurement")}

    @property
    def note(self) -> str | None:
        """What is seen in figures, and what to look for on the rig; None where the clause says it all."""
        return None
