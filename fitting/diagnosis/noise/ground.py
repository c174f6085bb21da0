"""The ground that every hypothesis is judged on: runs cut into lanes, the nominal model fitted to them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.cost import misfit_of
from fitting.diagnosis.lanes.jobs import job
from fitting.diagnosis.lanes.laying import LEAD, cut_in_step, divided, lay, length
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import LEAST, OWN, START
from fitting.diagnosis.noise.scatter import Scatter
from fitting.diagnosis.refits.refit import ITERATIONS, Refit, refit
from fitting.diagnosis.refits.release import all_settled, released, settled
from fitting.problem import Problem, beginnings
from fitting.progress import Progress, Silent
from fitting.segments import Segment
from fitting.settings import Settings
from fitting.stage import steps

UNITS = 4
"""Lanes are this many shortest segments long."""
FEW, MORE = 48, 192
"""The search begins on so many of the shortest segments, spread evenly; its best points go on on more."""
SEARCH, FINALISTS, REFINED = 25, 3, 15
WHOLE, SIFTED = 24, 8
"""Where no friction force was recorded, or the nominal model leaves much, points compete on so many whole
segments, spread evenly, for so many steps."""
ASTRAY, NOTABLY = 25.0, 0.9
"""Where the nominal model leaves more than so much, what it lacks may have led the search on the shortest
segments astray, so that all points compete on whole ones, too, if what they find leaves less by this factor:
a track whose waves leave 25 times the noise had led it to a tenth of the stiffness of the contact, and twice
the misfit that it leaves at the true one."""
HOPELESS = 3.0
"""A search that is not on its way to less than so many times the lowest cost is given up."""
STIFFER = (1.0, 20.0)
"""The search begins with the contact stiffness that is read off, and with so many times as much."""
STIFFNESSES = np.geomspace(1 / 30, 30, 15)
"""Contact stiffnesses that are tried once the other constants are about right, as shares of the one that was
found: lanes ring in stick, and a frequency that is off has minima of its own."""
RESTARTS = 2
TOLERANCE, NEARLY_ALL = 0.1, 0.9
WANDER = 0.01
"""How far friction is first taken to wander, as a share of itself."""


@dataclasses.dataclass(frozen=True)
class Ground:
    """Lanes of all runs, the nominal model at what the search for its constants found, the constants
    (coordinates) that the search began from, the shortest segments that it began on, and by how much the
    records scatter, where that is notably more than the noise."""

    segments: tuple[Segment, ...]
    bench: Bench
    point: Point
    begins: np.ndarray
    shortest: Bench
    scatter: Scatter | None = None


def ground(
    problem: Problem,
    model: Model,
    settings: Settings,
    progress: Progress,
    groups: Sequence[tuple[str, ...]] = (),
) -> Ground:
    """The nominal model, sought from several points on the shortest segments, where a misfit has hardly any
    local minima, and fitted to segments of about one natural period. Meanwhile programs are compiled for
    `groups` of effects, which will be asked for next."""
    samples = length(problem)
    segments, phases = cut_in_step(problem.chosen, samples)
    short = [part for segment in segments for part in divided(segment, UNITS)]
    begins = _beginnings(problem, settings)
    finest = _steps(problem, 1, list(begins), settings)
    shortest = lay(problem, short, [-1] * len(short), finest, samples // UNITS + 1, 0).coarser()
    progress.stage("nominal model", SEARCH + REFINED)
    laid = lay(problem, segments, phases, finest, samples, samples // LEAD)
    with model.ahead(laid.lanes, groups):
        best = sought(model, shortest, begins, progress)
        if not laid.wanders:
            best = _also_on_longer(model, laid, [*best, *begins])
        bench, fits = _refined(problem, model, laid, best, settings, progress)
        if laid.wanders and fits[0].misfit > ASTRAY:
            others = _also_on_longer(model, laid, list(begins))
            again = _refined(problem, model, laid, others, settings, Silent())
            if again[1][0].misfit < NOTABLY * fits[0].misfit:
                bench, fits = again
    if not bench.wanders:
        fits = model.side_by_side(lambda fit: released(model, bench, fit), fits)
    fit = min(fits, key=lambda fit: fit.misfit)
    widths = np.full(OWN - START, WANDER if bench.wanders else LEAST)
    return Ground(tuple(segments), bench, dataclasses.replace(fit.point, widths=widths), begins, shortest)


def _refined(
    problem: Problem,
    model: Model,
    laid: Bench,
    points: Sequence[np.ndarray],
    settings: Settings,
    progress: Progress,
) -> tuple[Bench, list[Refit]]:
    """The bench, with as many integration steps as the stiffest contact of the points asks for, and the
    nominal model fitted to it from each, the best first."""
    bench = laid.paced(_steps(problem, UNITS, points, settings))
    fits = _fitted(model, bench, points, progress, iterations=REFINED, settle=True)
    return bench, sorted(fits, key=lambda fit: fit.misfit)


def sought(model: Model, shortest: Bench, begins: np.ndarray, progress: Progress) -> list[np.ndarray]:
    """The best constants (coordinates) that a search from several finds on the shortest segments."""
    few = shortest.take(shortest.spread(FEW))
    rough = _fitted(model, few, list(begins), progress, iterations=SEARCH)
    others = other_stiffnesses(model, few, min(rough, key=lambda fit: fit.misfit))
    more = shortest.take(shortest.spread(MORE))
    return _best(model, _fitted(model, more, [*_best(model, rough), *others], Silent()))


def resolved(model: Model, bench: Bench, point: Point) -> Bench:
    """The bench with no more integration steps than residuals can tell: half or a quarter as many where, in
    nearly all lanes, that changes residuals by less than `TOLERANCE` standard deviations of the noise."""
    finest, *others = (
        (one, model.columns([job(model, one, point)])[0].residual[:, :-OWN])
        for one in (bench, bench.coarser(), bench.coarser().coarser())
    )
    counted = np.maximum(bench.lanes.counted(), 1)
    found = finest[0]
    for one, residual in others:
        error = np.sqrt(((residual - finest[1]) ** 2).sum(1) / counted)
        if not np.quantile(error, NEARLY_ALL) < TOLERANCE:
            break
        found = one
    return found


def _beginnings(problem: Problem, settings: Settings) -> np.ndarray:
    """Where the search begins: contacts that are read off are often far too soft, for a record shows how one
    gives way only while it sticks, so that stiffer ones are tried beside them."""
    points = beginnings(problem, settings)
    place = problem.unknowns.names.index("k1")
    values = problem.unknowns.members[place].to_value(points[:, place])
    out = []
    for factor in STIFFER:
        other = points.copy()
        other[:, place] = problem.unknowns.members[place].to_coordinate(factor * values)
        out.append(np.clip(other, problem.unknowns.lower, problem.unknowns.upper))
    return np.concatenate(out)


def other_stiffnesses(model: Model, bench: Bench, fit: Refit) -> list[np.ndarray]:
    """The constants (coordinates) of a fit with other stiffnesses of the contact: those at which lanes that
    settle cost least, but for its own."""
    (place,) = model.index("k1")
    constants, member = model.index(*model.constants), model.members[place]
    points = []
    for share in STIFFNESSES:
        coordinates = fit.point.coordinates.copy()
        coordinates[place] = member.to_coordinate(share * member.to_value(coordinates[place]))
        points.append(np.clip(coordinates, model.lower, model.upper))

    def cost(coordinates: np.ndarray) -> float:
        found = settled(model, bench, dataclasses.replace(fit.point, coordinates=coordinates))
        return misfit_of(found.cost, bench.dof())

    costs = model.side_by_side(cost, points)
    return [points[i][constants] for i in np.argsort(costs)[:RESTARTS] if not np.isclose(STIFFNESSES[i], 1.0)]


def _steps(problem: Problem, group: int, points: Sequence[np.ndarray], settings: Settings) -> int:
    """Integration steps a sample for segments of so many units and the stiffest contact of several points."""
    stiffest = max(problem.unknowns.values(coordinates)["k1"] for coordinates in points)
    return steps(problem, group, stiffest, settings)


def _best(model: Model, fits: Sequence[Refit]) -> list[np.ndarray]:
    """The constants (coordinates) of the best fits."""
    constants = model.index(*model.constants)
    found = sorted(fits, key=lambda fit: fit.misfit)[:FINALISTS]
    return [fit.point.coordinates[constants] for fit in found]


def _also_on_longer(model: Model, bench: Bench, points: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The best constants (coordinates) to go on from after all points have competed on some whole segments:
    on short ones the motion alone, where no friction force was recorded, hardly tells one law from another,
    and what the model lacks may outweigh what a law does."""
    few = bench.take(bench.spread(WHOLE))
    return _best(model, _fitted(model, few, points, Silent(), iterations=SIFTED, settle=True))


def _fitted(
    model: Model,
    bench: Bench,
    begin: Sequence[np.ndarray],
    progress: Progress,
    *,
    iterations: int = ITERATIONS,
    settle: bool = False,
) -> list[Refit]:
    """The constants fitted from several beginnings (coordinates), lanes starting as recorded, friction not
    wandering; where `settle`, every lane's start is first fitted by itself."""
    constants = model.index(*model.constants)
    own, widths = np.asarray(bench.lanes.start), np.full(OWN - START, LEAST)
    origin = Point((), model.origin({}), model.alike(bench.runs), own, widths)
    points = [origin.at_constants(model, values) for values in begin]
    if settle:
        points = all_settled(model, bench, points)
    return refit(
        model,
        bench,
        points,
        [constants] * len(points),
        iterations=iterations,
        wander=False,
        hopeless=HOPELESS,
        progress=lambda: progress.advance(),
    )
