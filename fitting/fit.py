"""The fit: from a data set to friction constants with honest intervals."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fitting.descent import Descent, descend
from fitting.account import account_for
from fitting.intervals import Interval, interval
from fitting.lanes import Lanes, Misfit
from fitting.newton import Robust, Solution, solve, unstick
from fitting.opening import Scales, opening, scales
from fitting.progress import Progress, Silent
from fitting.result import Constant, Fit
from fitting.segments import Segment, cut, lay_out
from fitting.settings import Settings
from fitting.signals import Signals, natural_period, read_signals
from fitting.uncertainty import Spread, spread
from fitting.unknowns import Unknown, Unknowns
from jaxstick.errors import UserError
from jaxstick.hypothesis import Hypothesis, effects_at_null
from jaxstick.nominal import nominal
from jaxstick.parameter import find, parameters
from jaxstick.parts.drive import SineDrive
from jaxstick.record import AssumedConstants, DataSet, KnownRig
from jaxstick.simulate import shortest_period, substeps

CONSTANTS = ("A", "B", "C", "D", "k1")
DESCENT_LANES = 48
FINALISTS = 3
CLUSTER_PERIODS = 5.0
PRIOR_SHARE = {"damping": 0.2, "drive_damping": 0.2}


def fit(dataset: DataSet, settings: Settings | None = None, progress: Progress | None = None) -> Fit:
    """Fits A, B, C, D, k1 (and what `settings` free besides) to the runs of a data set that are not held out.

    Every run is cut into segments with free starts; descents by Adam from several points choose the basin,
    Levenberg-Marquardt with the starts eliminated finishes, and intervals come from the cluster-robust
    covariance or the profile.

    Raises UserError for settings that do not suit the data, before anything is computed.
    """
    settings = settings or Settings()
    progress = progress or Silent()
    signals = [read_signals(run, dataset.noise) for run in dataset.runs]
    chosen = [signal for signal in signals if not signal.run.hold_out]
    scale = scales(chosen)
    first = opening(chosen, scale)
    hypothesis = _hypothesis(dataset, first, settings)
    unknowns = _unknowns(hypothesis, dataset.rig, scale, settings)
    period = _time_scale(chosen)
    length = None if settings.horizon is None else settings.horizon * period
    segments = cut(chosen, length)
    clusters = _clusters(chosen, segments, CLUSTER_PERIODS * period)
    points = _points(unknowns, hypothesis, first, dataset.assumed, settings)

    steps = _substeps(chosen, hypothesis, first["k1"], settings.resolution)
    lanes = lay_out(chosen, segments, dataset.rig, scale.force, steps)
    misfit = Misfit(hypothesis, unknowns, lanes=len(lanes), workers=settings.workers)
    descent, solution = _search(misfit, lanes, points, settings, progress)
    needed = _substeps(chosen, hypothesis, _value(unknowns, solution, "k1"), settings.resolution)
    if needed > 1.25 * steps:
        lanes = dataclasses.replace(lanes, substeps=needed)
        misfit = Misfit(hypothesis, unknowns, lanes=len(lanes), workers=settings.workers)
        solution = _finish(misfit, lanes, [(solution.coordinates, solution.starts)], progress)

    intervals = _intervals(misfit, lanes, solution, clusters, progress)
    constants = [
        _constant(unknown, at, found, dataset.assumed)
        for unknown, at, found in zip(unknowns.members, solution.coordinates, intervals, strict=True)
    ]
    best = unknowns.insert(hypothesis, solution.coordinates)
    account = account_for(
        signals,
        dataset.rig,
        misfit,
        solution.coordinates,
        length=length,
        force_scale=scale.force,
        substeps=lanes.substeps,
        progress=progress,
    )
    dof = lanes.counted()
    return Fit(
        outcome="converged" if solution.converged else "the least-squares search did not converge",
        constants=tuple(constants[: len(CONSTANTS)]),
        others=tuple(constants[len(CONSTANTS) :]),
        hypothesis=best,
        gaps=account.gaps,
        free_runs=account.free_runs,
        chi2_per_sample=float(solution.linear.cost.sum() / dof.sum()),
        excluded_segments=int(np.sum(solution.weights < 0.5)),
        segments=len(lanes),
        traces=account.traces,
        descent=descent.history,
        finish=solution.history,
        settings=dataclasses.asdict(settings),
        sha256=dataset.sha256,
        notices=dataset.notices,
    )


def _hypothesis(dataset: DataSet, first: dict[str, float], settings: Settings) -> Hypothesis:
    placeholder = SineDrive(frequency=1.0)
    oscillator = nominal(dataset.rig, AssumedConstants(**first), placeholder)
    return Hypothesis(oscillator, effects_at_null(settings.effects))


def _unknowns(hypothesis: Hypothesis, rig: KnownRig, scale: Scales, settings: Settings) -> Unknowns:
    """The constants within bounds set by the sizes in the data, effects' parameters, freed rig parameters."""
    force, speed, travel = scale.force, scale.speed, scale.displacement
    members = [
        Unknown("A", "N", 0.0, 3 * force, "linear", force),
        Unknown("B", "s/m", 0.05 / speed, 2000 / speed, "log"),
        Unknown("C", "N", 0.0, 3 * force, "linear", force),
        Unknown("D", "N s/m", 0.0, 3 * force / speed, "linear", force / speed),
        Unknown("k1", "N/m", force / travel, 5000 * force / travel, "log"),
    ]
    for key, effect in hypothesis.effects.items():
        for place in parameters(effect):
            unit, lower, upper = place.parameter.unit, place.parameter.lower, place.parameter.upper
            size = force if unit == "N" else 1.0
            members.append(
                Unknown(
                    f"{key}.{place.path[-1]}",
                    unit,
                    max(lower, -3 * size),
                    min(upper, 3 * size),
                    "linear",
                    size,
                )
            )
    for name in settings.free:
        members.append(_freed(hypothesis, rig, name))
    return Unknowns(tuple(members))


def _freed(hypothesis: Hypothesis, rig: KnownRig, name: str) -> Unknown:
    known = {place.path[-1]: place.parameter for place in parameters(hypothesis.nominal.rig)}
    if name not in known:
        raise UserError(f"{name!r} is not a parameter of the rig; those that can be freed are {', '.join(known)}.")
    value = getattr(rig, name)
    if value <= 0:
        raise UserError(f"{name!r} is stated as {value:g}; only a parameter with a stated value can be freed.")
    share = PRIOR_SHARE.get(name, 0.02)
    return Unknown(name, known[name].unit, value / 3, value * 3, "log", 1.0, value, share * value)


def _time_scale(signals: Sequence[Signals]) -> float:
    """The natural period of the rig [s]; a hundred samples where it has no springs."""
    return max(natural_period(signal.run.rig) or 100 * signal.run.interval for signal in signals)


def _clusters(signals: Sequence[Signals], segments: Sequence[Segment], length: float) -> np.ndarray:
    """Which segments lie close enough for their errors to be correlated: stretches of `length` s of a run."""
    labels: dict[tuple[int, int], int] = {}
    out = []
    for segment in segments:
        run = signals[segment.run].run
        middle = (segment.first + segment.last) / 2 * run.interval
        block = (segment.run, int(middle // length))
        out.append(labels.setdefault(block, len(labels)))
    return np.array(out)


def _substeps(signals: Sequence[Signals], hypothesis: Hypothesis, k1: float, resolution: float) -> int:
    contact = dataclasses.replace(hypothesis.nominal.contact, k1=k1)
    period = shortest_period(dataclasses.replace(hypothesis.nominal, contact=contact))
    interval = max(signal.run.interval for signal in signals)
    return min(substeps(interval, period, resolution), 64)


def _points(
    unknowns: Unknowns,
    hypothesis: Hypothesis,
    first: dict[str, float],
    assumed: AssumedConstants,
    settings: Settings,
) -> np.ndarray:
    """Where the descents begin: read off the data, assumed today, and scattered around the first."""
    rest = {name: float(find(hypothesis, name).of(hypothesis)) for name in unknowns.names if name not in first}
    stated = {name: getattr(assumed, name) for name in CONSTANTS}
    points = [unknowns.coordinates({**first, **rest})]
    if all(value is not None for value in stated.values()):
        points.append(unknowns.coordinates({**stated, **rest}))
    random = np.random.default_rng(settings.seed)
    spread_of = {"A": 0.7, "B": 0.9, "C": 0.15, "D": 1.0, "k1": 0.7}
    while len(points) < settings.starts:
        scattered = {name: value * math.exp(spread_of[name] * random.standard_normal()) for name, value in first.items()}
        points.append(unknowns.coordinates({**scattered, **rest}))
    return np.array(points[: max(1, settings.starts)])


def _search(
    misfit: Misfit, lanes: Lanes, points: np.ndarray, settings: Settings, progress: Progress
) -> tuple[Descent, Solution]:
    progress.stage("descent", settings.descent_iterations)
    few = lanes.take(np.unique(np.linspace(0, len(lanes) - 1, DESCENT_LANES).round().astype(int)))
    descent = descend(
        misfit,
        few,
        points,
        iterations=settings.descent_iterations,
        progress=lambda loss: progress.advance(f"loss {loss:.3g}"),
    )
    order = np.argsort(descent.loss)[:FINALISTS]
    start = np.asarray(lanes.start)
    finalists = [(descent.coordinates[number], start) for number in order]
    return descent, _finish(misfit, lanes, finalists, progress)


def _finish(
    misfit: Misfit, lanes: Lanes, finalists: list[tuple[np.ndarray, np.ndarray]], progress: Progress
) -> Solution:
    """Least squares over all lanes from each finalist; the best, after its stuck segments were freed."""
    progress.stage("least squares", 12 * len(finalists) + 8)

    def tell(cost: float) -> None:
        progress.advance(f"chi2 {cost:.6g}")

    solutions = [solve(misfit, lanes, *finalist, progress=tell) for finalist in finalists]
    best = min(solutions, key=lambda solution: solution.cost)
    for attempt in range(3):
        starts = unstick(misfit, lanes, best.coordinates, best.starts, best.linear.cost, seed=attempt)
        if starts is None:
            break
        best = solve(misfit, lanes, best.coordinates, starts, progress=tell)
    return best


def _intervals(
    misfit: Misfit, lanes: Lanes, solution: Solution, clusters: np.ndarray, progress: Progress
) -> list[Interval]:
    n = len(misfit.unknowns)
    progress.stage("intervals", n)
    _, _, prior = misfit.unknowns.prior(solution.coordinates)
    spreads: tuple[Spread, Spread] = (
        spread(solution, clusters, ~solution.at_bound, prior),
        spread(solution, clusters, np.ones(n, bool), prior),
    )
    dof = lanes.counted()
    robust = Robust.around(solution.linear.cost, dof)
    out = []
    for index, name in enumerate(misfit.unknowns.names):
        out.append(interval(misfit, lanes, solution, robust, spreads, index))
        progress.advance(name)
    return out


def _value(unknowns: Unknowns, solution: Solution, name: str) -> float:
    return unknowns.values(solution.coordinates)[name]


def _constant(unknown: Unknown, at: float, found: Interval, assumed: AssumedConstants) -> Constant:
    def value(coordinate: float | None) -> float | None:
        return None if coordinate is None else float(unknown.to_value(coordinate))

    middle = float(unknown.to_value(at))
    deviation = found.deviation * (middle if unknown.kind == "log" else unknown.scale)
    return Constant(
        name=unknown.name,
        value=middle,
        low=value(found.low),
        high=value(found.high),
        unit=unknown.unit,
        assumed=getattr(assumed, unknown.name, None) if unknown.centre is None else unknown.centre,
        standard_error=deviation if math.isfinite(deviation) and deviation > 0 else None,
        method=found.method,
    )
