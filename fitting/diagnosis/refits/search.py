"""One search by Levenberg and Marquardt, in which what lanes have of their own is eliminated lane by lane."""

from __future__ import annotations

import dataclasses

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.centring import centred
from fitting.diagnosis.lanes.columns import Columns
from fitting.diagnosis.lanes.cost import data_cost, misfit_of, whole_cost
from fitting.diagnosis.lanes.equations import fall, normal
from fitting.diagnosis.lanes.jobs import chosen_columns
from fitting.diagnosis.lanes.layout import Layout, Prior
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import OWN, START, likeliest
from fitting.newton import Robust, bounded_step

ENOUGH, ENOUGH_OF_SCATTER = 2e-4, 1e-3
"""A search is over when a step has gained, or promises to gain, less than this share of the cost. Where
residuals are weighed by what does not repeat itself, a lane is worth few independent pieces of evidence, and
five times as much tells nothing."""
DAMPED, LEAST_DAMPED, STUCK = 1e-3, 1e-4, 1e4
"""The damping that a search begins with, what it does not fall below, for steps hardly differ there, and one
that is refused would be tried over and over, and where a search is given up."""
HEAVY = 1.0
"""Steps that are damped by more gain little because they are short, and end no search: behind a bend in the
cost, where lanes come to an event or lose one, longer ones often gain again."""
EASED, GROWS = 0.1, 10.0
"""By what factor a step that is taken changes the damping, and one that is refused."""


class Search:
    """One search under way."""

    def __init__(
        self,
        model: Model,
        bench: Bench,
        point: Point,
        free: np.ndarray,
        wander: bool,
        enough: float | None = None,
    ) -> None:
        self.model, self.bench, self.point, self.free = model, bench, point, free
        self.wander = wander and bench.wanders
        self.chosen = chosen_columns(free, model.level, len(bench.lanes))
        self.dof = bench.dof()
        self.damping, self.cost, self.gain = DAMPED, np.inf, np.inf
        self.over, self.taken = False, 0
        usual = ENOUGH_OF_SCATTER if bench.scatters else ENOUGH
        self.enough = usual if enough is None else enough
        self.layout = Layout.of(model, bench, free)
        self.centres = self.wander and self.layout.fits_friction(model)
        self.lower, self.upper = self.layout.bounds(model)

    def see(self, point: Point, columns: Columns, first: bool) -> None:
        """Takes the point if its cost is lower."""
        cost = whole_cost(columns)
        loss = Robust.around(cost, self.dof) if first else self.loss
        total = loss.total(cost) + self._prior(point).cost
        if not first and not total < self.cost:
            self.damping *= GROWS
            self.over = self.damping > STUCK
            return
        self.gain = gain = self.cost - total
        self.point, self.lane_cost, self.data = point, cost, data_cost(columns)
        self.gradient, self.curvature = normal(columns)
        moved = self._let_wander()
        cost = self.lane_cost
        self.loss = Robust.around(cost, self.dof)
        self.cost = self.loss.total(cost) + self._prior(point).cost
        if not first:
            self.damping = max(EASED * self.damping, LEAST_DAMPED)
            self.taken += 1
            self.over = gain < self.enough * total and not moved and self.damping <= HEAVY

    def _let_wander(self) -> bool:
        """Sets the widths to the likeliest ones at this point, and says whether they changed."""
        own, widths = self.point.own, self.point.widths
        found = likeliest(
            own,
            self.gradient[:, -OWN:],
            self.curvature[:, -OWN:, -OWN:],
            widths,
            self.data / self.dof,
        )
        self.price, self.levels = found.price, found.levels
        if not self.wander or np.array_equal(found.widths, widths):
            return False
        change = found.widths**-2.0 - widths**-2.0
        wandered = own[:, START:]
        places = np.arange(START - OWN, 0)
        self.gradient[:, places] += change * wandered
        self.curvature[:, places, places] += change
        dearer = (change * wandered**2).sum(1)
        self.lane_cost, self.data = self.lane_cost + dearer, self.data + dearer
        self.point = dataclasses.replace(self.point, widths=found.widths)
        return True

    def _prior(self, point: Point) -> Prior:
        return self.layout.prior(self.model, point)

    def step(self) -> Point:
        """Where the next damped step leads; what lanes have of their own is eliminated lane by lane. The
        search is over where the step promises next to nothing."""
        g, h, solved = self._without_own(self.damping)
        _, prior_gradient, prior = self._prior(self.point)
        at = self.layout.values(self.point)
        step, _ = bounded_step(
            at,
            g + prior_gradient,
            h + prior,
            self.damping,
            np.zeros(len(at), bool),
            self.lower,
            self.upper,
        )
        reached = np.clip(at + step, self.lower, self.upper)
        step = reached - at
        mine = step[self.layout.index[self.bench.run]]
        answer = -solved[:, :, 0] - np.einsum("lsc,lc->ls", solved[:, :, 1:], mine)
        promised = self.weights @ self._fall(np.concatenate([mine, answer], axis=1))
        promised -= step @ (2 * prior_gradient + prior @ step)
        self.over = bool(promised < self.enough * self.cost) and self.damping <= HEAVY
        own = self.point.own + answer
        point = dataclasses.replace(self.layout.moved(self.model, self.point, reached), own=own)
        return centred(self.model, self.bench, point) if self.centres else point

    def _without_own(self, damping: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gradient and curvature of the unknowns, what lanes have of their own eliminated lane by lane, and
        how that answers to the gradient of a lane and to its unknowns (lanes, own, 1 + unknowns)."""
        own = self.curvature[:, -OWN:, -OWN:]
        own = own * (1 + damping * np.eye(OWN))
        used = 1 + len(self.free)
        coupling = self.curvature[:, -OWN:, :used]
        solved = np.linalg.solve(own, np.concatenate([self.gradient[:, -OWN:, None], coupling], axis=2))
        gradient = self.gradient[:, :used] - np.einsum("lsc,ls->lc", coupling, solved[:, :, 0])
        curvature = self.curvature[:, :used, :used] - np.einsum("lsc,lsd->lcd", coupling, solved[:, :, 1:])
        weights = self.weights
        g, h = self.layout.summed(
            self.bench.run, gradient * weights[:, None], curvature * weights[:, None, None]
        )
        return g, h, solved

    @property
    def misfit(self) -> float:
        """Chi-square per degree of freedom, with what the freedom of friction to wander costs."""
        return misfit_of(self.data, self.dof) * float(np.exp(self.price / self.dof.sum()))

    @property
    def weights(self) -> np.ndarray:
        """How much every lane counts."""
        return self.loss.weights(self.lane_cost)

    def told(self) -> dict[int, float]:
        """How many times as much as its prior the records say of each free unknown; infinite without one."""
        _, h, _ = self._without_own(LEAST_DAMPED)
        prior = self._prior(self.point).curvature
        variance = np.diag(np.linalg.pinv(h + prior, hermitian=True))[self.layout.of_free]
        assumed = np.diag(prior)[self.layout.of_free]
        with np.errstate(divide="ignore"):
            told = np.maximum(1.0 / (assumed * np.maximum(variance, 1e-300)) - 1.0, 0.0)
        return dict(zip(self.free.tolist(), told.tolist(), strict=True))

    def _fall(self, change: np.ndarray) -> np.ndarray:
        """By how much the linearised cost of every lane falls for a change of its unknowns, its own last."""
        used = np.r_[: 1 + len(self.free), -OWN:0]
        return fall(self.gradient[:, used], self.curvature[:, used[:, None], used], change)
