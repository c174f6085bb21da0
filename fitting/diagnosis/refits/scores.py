"""Scores of effects: by how much chi-square would fall, were a strength let free, all else projected out.

At a fitted hypothesis residuals are linear in the strengths; what every lane has of its own, the unknowns
that were fitted and the levels of friction answer to a strength before it counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.lanes.equations import Projection
from fitting.diagnosis.lanes.jobs import job, whole_columns
from fitting.diagnosis.lanes.layout import Layout, owners
from fitting.diagnosis.lanes.model import Job, Model
from fitting.diagnosis.lanes.wander import allowed
from fitting.diagnosis.refits.refit import Refit

PEAK, EDGES = 4.0, 0.95
"""What a time does to a sample counts up to so many times what it does to one of its edges, this quantile."""


def places_of(model: Model, bench: Bench, keys: Sequence[str]) -> list[np.ndarray]:
    """Where the strengths of effects stand among the columns of a template."""
    counts = [len(owners(model, bench, key)) for key in keys]
    ends = np.cumsum(counts)
    return [np.arange(end - count, end) for end, count in zip(ends, counts, strict=True)]


class Projected(NamedTuple):
    """Columns of every lane (lanes, rows, columns), weighted and with the lane's own projected out, and how
    the lane's own answers to them (lanes, own, columns)."""

    columns: np.ndarray
    answer: np.ndarray

    def beside(self, other: Projected) -> Projected:
        """The columns of both."""
        return Projected(*(np.concatenate(both, axis=2) for both in zip(self, other, strict=True)))

    def less(self, other: Projected, place: np.ndarray, amounts: np.ndarray) -> Projected:
        """The same without so much of some columns of another in the last column."""
        made = Projected(self.columns.copy(), self.answer.copy())
        for mine, theirs in zip(made, other, strict=True):
            mine[:, :, -1] -= theirs[:, :, place] @ amounts
        return made


def templates_of(
    model: Model, bench: Bench, at: Refit, groups: Sequence[tuple[str, ...]], points: Sequence[np.ndarray]
) -> tuple[Projected, list[Projected]]:
    """Level, base unknowns and residual per lane (1 + base + 1 columns), and for every point the columns of
    all strengths."""
    count, deviation = len(bench.lanes), allowed(bench.lanes, at.point.widths)
    every = np.tile(np.arange(count), len(points))
    jobs = [job(model, bench, at.point, at.free)]
    asked: list[np.ndarray] = []
    for group in groups:
        wanted = np.concatenate([model.index(*model.shelf.strengths[key]) for key in group])
        each = np.repeat(points, count, axis=0)
        each[:, model.by_run] = at.point.by_run[np.tile(bench.run, len(points))]
        attached = at.point.arranged(model.sharing.seen(group, at.point.keys))
        own, chosen = at.point.own[every], whole_columns(wanted, len(every))
        jobs.append(Job(attached, bench.lanes, deviation[every], each, own, chosen, bench.whitener))
        asked.append(wanted)
    base, *others = model.columns(jobs)
    project = Projection(base)
    root = np.sqrt(at.weights)[:, None, None]

    def seen(columns: np.ndarray) -> Projected:
        return Projected(project(columns * root), project.answer(columns))

    unknowns = base.jacobian[:, :, : 1 + len(at.free)]
    common = seen(np.concatenate([unknowns, base.residual[:, :, None]], axis=2))
    templates = []
    for number in range(len(points)):
        own = slice(number * count, (number + 1) * count)
        columns = [
            column
            for other, wanted in zip(others, asked, strict=True)
            for column in _run_by_run(model, bench, wanted, bounded(model, wanted, other.jacobian[own]))
        ]
        templates.append(seen(np.concatenate(columns, axis=2)))
    return common, templates


def bounded(model: Model, numbers: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
    """The columns of strengths (lanes, rows, ..), those of times without their peaks: a jump of the force
    within one step, shifted in time, would outweigh all that is to be seen elsewhere."""
    lasting = [place for place, number in enumerate(numbers.tolist()) if model.members[number].unit == "s"]
    if not lasting:
        return jacobian
    seen = jacobian.copy()
    for place in lasting:
        size = np.abs(jacobian[:, :, place])
        most = PEAK * np.quantile(size[size > 0], EDGES) if np.any(size > 0) else 0.0
        seen[:, :, place] = np.clip(jacobian[:, :, place], -most, most)
    return seen


def _run_by_run(model: Model, bench: Bench, numbers: np.ndarray, jacobian: np.ndarray) -> list[np.ndarray]:
    """The columns (lanes, rows, ..) of strengths, one that every run has of its own as a column for each."""
    mine = (bench.run[:, None] == np.unique(bench.run))[:, None, :]
    return [
        jacobian[:, :, [place]] * (mine if number in model.by_run else 1.0)
        for place, number in enumerate(numbers.tolist())
    ]


class Table:
    """Products of the strengths' columns with one another and with the residual, the base eliminated.

    gram: those of all lanes, the residual last; by_lane (lanes, strengths): those with the residual lane by
    lane; response, answers: how the unknowns that were fitted answer to each column, all of them and by lane
    (lanes, unknowns, columns); own: how what lanes have of their own does.
    """

    def __init__(
        self,
        model: Model,
        bench: Bench,
        at: Refit,
        common: Projected,
        templates: Projected,
    ) -> None:
        self.model, self.bench = model, bench
        base = common.columns[:, :, :-1]
        own = base.transpose(0, 2, 1)
        wanted = np.concatenate([templates.columns, common.columns[:, :, -1:]], axis=2)
        across = own @ wanted
        layout = Layout.of(model, bench, at.free)
        coupling, curvature = layout.summed(bench.run, across, own @ base)
        prior = layout.prior(model, at.point)
        coupling[:, -1] += prior.gradient
        curvature += prior.curvature
        curvature += np.diag(1e-12 * np.diag(curvature) + 1e-30)
        slope = np.linalg.solve(curvature, coupling)
        products = wanted.transpose(0, 2, 1) @ wanted
        self.gram = products.sum(0) - coupling.T @ slope
        self.response = -slope
        self.answers = self.response[layout.index[bench.run]]
        self.own = np.concatenate([templates.answer, common.answer[:, :, -1:]], axis=2)
        self.own = self.own + np.einsum("lob,lbe->loe", common.answer[:, :, :-1], self.answers)
        by_lane = products[:, :, -1] + np.einsum("lc,lce->le", across[:, :, -1], self.answers)
        self.by_lane = by_lane[:, :-1]

    def information(self, place: np.ndarray) -> np.ndarray:
        """The curvature of chi-square over some columns, kept from being singular."""
        information = self.gram[np.ix_(place, place)]
        return information + np.diag(1e-9 * np.diag(information) + 1e-30)

    def cosines(self, places: Sequence[np.ndarray]) -> np.ndarray:
        """The largest cosine between any combinations of two effects' columns (canonical correlation)."""
        roots = []
        for place in places:
            value, vector = np.linalg.eigh(self.gram[np.ix_(place, place)])
            keep = value > 1e-9 * max(value.max(), 1e-300)
            roots.append(vector[:, keep] / np.sqrt(value[keep]))
        out = np.eye(len(places))
        for i, one in enumerate(places):
            for j, other in enumerate(places[:i]):
                across = roots[i].T @ self.gram[np.ix_(one, other)] @ roots[j]
                largest = np.linalg.svd(across, compute_uv=False).max(initial=0.0)
                out[i, j] = out[j, i] = min(float(largest), 1.0)
        return out
