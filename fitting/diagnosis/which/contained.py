"""What contains another hypothesis can leave no more than that, and what leaves a little more than the best
may leave as little: refits that end above have gone astray, or stopped early."""

from __future__ import annotations

from collections.abc import Sequence

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.refits.release import borrowed, released
from fitting.diagnosis.which.explanation import Explanation, best_of

RIVALS = 1.15
"""Where the best explanation leaves so many times less than the nominal model, those above that one are no
rivals of it."""
CLOSE = 1.05
"""What leaves no more than so many times what the best does may have stopped early."""
FEW = 3
"""So many of these at most are fitted again."""


def lent(model: Model, bench: Bench, base: Refit, found: Sequence[Explanation]) -> list[Explanation]:
    """Explanations in the same order; those that have ended above the base with its lanes and constants lent
    to them, where that makes them better."""

    def one(e: Explanation) -> Explanation:
        return e.fitted(borrowed(model, bench, e.refit, base))

    return model.side_by_side(one, found)


def none_above(model: Model, bench: Bench, nominal: Refit, found: Sequence[Explanation]) -> list[Explanation]:
    """The explanations, best first, of which those that have ended above the nominal model are freed of their
    lost lanes and borrow from it; as they are where the best leaves far less than it."""
    if nominal.misfit > RIVALS * min(e.refit.misfit for e in found):
        return list(found)

    def free(e: Explanation) -> Explanation:
        return e.fitted(released(model, bench, e.refit))

    above = [e for e in found if e.refit.misfit > nominal.misfit]
    rest = [e for e in found if e.refit.misfit <= nominal.misfit]
    return best_of([*rest, *lent(model, bench, nominal, model.side_by_side(free, above))])


def brought_level(model: Model, bench: Bench, found: Sequence[Explanation]) -> list[Explanation]:
    """The explanations, best first; the next ones that leave hardly more than the best, and have as many
    effects, with its lanes and constants lent to them. An offset, say, is a high-pass without a corner: which
    of the two a search has followed further must not decide between them."""
    best, *others = found = best_of(found)
    close = [
        e for e in others if e.refit.misfit < CLOSE * best.refit.misfit and len(e.keys) == len(best.keys)
    ][:FEW]
    if not close:
        return found
    return best_of([*found, *lent(model, bench, best.refit, close)])
