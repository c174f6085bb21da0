"""A few steps of many starts on few lanes."""

from __future__ import annotations

from collections.abc import Sequence

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import refit
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.starts import Start
from fitting.progress import Progress

HEAT = 8
"""Steps that starts compete for."""


def heats(
    model: Model, heat: Bench, starts: Sequence[Start], progress: Progress, *, wander: bool
) -> list[Explanation]:
    """All starts fitted for `HEAT` steps to a part of the lanes."""
    points, frees = [each.point for each in starts], [each.free for each in starts]
    tried = refit(
        model, heat, points, frees, iterations=HEAT, wander=wander, progress=lambda: progress.advance()
    )
    return [Explanation(s.keys, s.promise, fit) for s, fit in zip(starts, tried, strict=True)]
