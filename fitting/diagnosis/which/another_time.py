"""What keeps another time than the excitation does: it does not repeat itself from cycle to cycle either, and
is no scatter."""

from __future__ import annotations

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.repeatability import floor_of
from fitting.diagnosis.which.contest import contest
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.screen import Shapes, screen
from fitting.diagnosis.which.starts import FROM_NEARBY
from fitting.diagnosis.which.survey import freed
from fitting.progress import Progress

A_GOOD_PART = 0.3
"""No effect promises to take such a share of what the best one leaves where that scatters, nor takes it of
what does not repeat itself: by chance nothing keeps the time that an effect does."""
FEW = 2
"""So many effects are tried beside the best one."""


def in_another_time(
    model: Model, bench: Bench, best: Explanation, shapes: Shapes, progress: Progress
) -> Explanation | None:
    """The best effect, under which a good deal does not repeat itself, with a second that takes most of it: a
    hum beside a force that is clipped. None where there is no such thing."""
    seen = screen(model, bench, best.refit, shapes=shapes)
    worth = A_GOOD_PART * best.refit.misfit * float(bench.dof().sum())
    promises = [each for each in seen.ranked if each.feasible and each.score > worth][:FEW]
    if not promises:
        return None
    two, *_ = freed(model, bench, contest(model, bench, best.refit, promises, FEW, progress, FROM_NEARBY))
    before, after = (floor_of(model, bench, [e.refit]) for e in (best, two))
    return two if after < (1 - A_GOOD_PART) * before else None
