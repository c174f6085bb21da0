"""How far an effect takes the records from what any nominal model could follow, in units of their noise.

The run with effects is cut into windows. From its own state at the start of each, the same rig without the
effects is simulated through the window; the difference of the channels is what the effect did there. What new
initial states and constants could make good of it is projected out, linearly, with derivatives by finite
differences; the root mean square of the rest over the noise is the gap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fitting.blind.formulation import Floats
from fitting.blind.march import BASE, ELEMENT, STATE, V, X, march_windows
from fitting.blind.recipe import Chosen, Recipe
from fitting.blind.scales import Scales
from fitting.blind.truth import (
    COARSE,
    OVERSAMPLING,
    Acting,
    acting,
    initial_state,
    moved,
    sense,
    signals_of,
)

WINDOW = 1.0
"""Length of a window in natural periods."""

MOST_WINDOWS = 10
"""Windows of one run that are looked at, evenly spread."""

CONSTANTS = ("A", "B", "C", "D", "k1")
RIG_PRIOR = {"mass": 0.01, "stiffness": 0.01, "drive_stiffness": 0.01, "damping": 0.2, "drive_damping": 0.2}
"""How well a rig is taken to be known, relative (dampers: to the damping c)."""

NUDGE = 1e-8
"""Step of finite differences, as a share of each constant: so small that no event passes a reading."""

THRESHOLD = 30.0
"""The excess of chi-square at which an effect is found in nine of ten records: (sqrt(17.7) + 1.28)^2."""


@dataclass(frozen=True)
class Gap:
    """Root mean square over the noise of what constants and initial states cannot make good.

    fixed_rig: with the rig as it is; free_rig: with the rig's constants free as far as they are unknown.
    """

    fixed_rig: float
    free_rig: float


def detection_limit(recipe: Recipe) -> float:
    """The gap that an ideal observer finds in nine of ten such records."""
    return float(np.sqrt(THRESHOLD / sum(2 * plan.samples for plan in recipe.runs)))


def gap(recipe: Recipe, effects: Sequence[Chosen], scales: Scales) -> Gap:
    """The gap that `effects` open in the runs of the recipe; infinite where they let the motion diverge."""
    blocks = [_run_block(recipe, index, effects, scales) for index in range(len(recipe.runs))]
    rest = np.concatenate([block[0] for block in blocks])
    columns = np.concatenate([block[1] for block in blocks])
    size = np.sqrt(len(rest))
    if not (np.isfinite(rest).all() and np.isfinite(columns).all()):
        return Gap(np.inf, np.inf)
    count = len(CONSTANTS)
    fixed = rest - columns[:, :count] @ _solved(columns[:, :count], rest, np.full(count, 1e-6))
    freedom = np.concatenate((np.full(count, 1e-6), np.ones(columns.shape[1] - count)))
    free = rest - columns @ _solved(columns, rest, freedom)
    return Gap(float(np.linalg.norm(fixed) / size), float(np.linalg.norm(free) / size))


def _solved(columns: Floats, rest: Floats, prior: Floats) -> Floats:
    """Least squares with `prior` on the squares of the unknowns, in units of their prior's width."""
    solved = np.linalg.solve(columns.T @ columns + np.diag(prior), columns.T @ rest)
    return np.asarray(solved, dtype=np.float64)


def _run_block(
    recipe: Recipe, index: int, effects: Sequence[Chosen], scales: Scales
) -> tuple[Floats, Floats]:
    """Whitened residuals (values,) of one run, their derivatives (values, unknowns); states projected out."""
    plan = recipe.runs[index]
    length = min(max(round(WINDOW * scales.period / recipe.interval), 8), plan.samples - 1)
    starts = _starts(plan.samples, length)
    run = acting(recipe, index, effects)
    state = initial_state(run)
    pieces, states, at = [], [], -plan.settling
    for start in (*starts, plan.samples):
        pieces.append(_onward(run, state, at, start))
        states.append(state.copy())
        at = start
    rows = np.concatenate(pieces)
    signals = sense(recipe, index, effects, signals_of(run, rows))
    view = acting(replace(recipe, effects=tuple(effects)), index, (), seen=True)
    begun = _as_seen(np.array(states[:-1]), run, view, np.array(starts) * recipe.interval)
    offsets = (np.array(starts)[:, None] + plan.settling + np.arange(1, length + 1)) * OVERSAMPLING - 1
    recorded = np.stack((signals.displacement[offsets], signals.friction[offsets]), axis=-1)
    noise = np.array([recipe.displacement.deviation, recipe.friction.deviation])

    def simulated(seen: Acting, states: Floats) -> Floats:
        out = np.empty((len(starts), length, 2))
        times = np.array(starts) * recipe.interval
        march_windows(
            seen.record, seen.elements, seen.series, seen.start, seen.interval, states.copy(), times,
            seen.interval / (OVERSAMPLING * COARSE), OVERSAMPLING * COARSE, length, out,
        )  # fmt: skip
        return (out / noise).reshape(len(starts), -1)

    base = simulated(view, begun)
    rest = (recorded / noise).reshape(len(starts), -1) - base
    local = [
        (simulated(view, _nudged(begun, place, width * NUDGE)) - base) / NUDGE
        for place, width in ((X, scales.stroke), (V, scales.speed), (ELEMENT, scales.stick))
    ]
    common = [
        (simulated(_perturbed(view, name, size * NUDGE), begun) - base) * (unit / (size * NUDGE))
        for name, (unit, size) in _widths(view, scales).items()
    ]
    everything = np.stack((rest, *common), axis=-1)
    return _without_states(np.stack(local, axis=-1), everything)


def _starts(samples: int, length: int) -> list[int]:
    """Where the windows of a run begin."""
    count = max(min((samples - 1) // length, MOST_WINDOWS), 1)
    return np.linspace(0, samples - 1 - length, count).astype(int).tolist()


def _onward(run: Acting, state: Floats, start: int, end: int) -> Floats:
    return moved(run, state, start * run.interval, (end - start) * OVERSAMPLING, COARSE)


def _as_seen(states: Floats, run: Acting, view: Acting, times: Floats) -> Floats:
    """The states for the simulation without effects: its own base, and one deflection of its own elements."""
    p = view.physics
    angle = p.omega * times + p.phase
    states[:, BASE] = p.amplitude * (np.sin(angle) + p.third_harmonic * np.sin(3.0 * angle + p.third_phase))
    if len(run.elements) != len(view.elements):
        count = len(run.elements)
        states[:, ELEMENT:STATE] = (states[:, ELEMENT : ELEMENT + count] @ run.elements[:, 0])[:, None]
    return states


def _nudged(states: Floats, place: int, change: float) -> Floats:
    nudged = states.copy()
    if place == ELEMENT:
        nudged[:, ELEMENT:STATE] += change
    else:
        nudged[:, place] += change
    return nudged


def _widths(view: Acting, scales: Scales) -> dict[str, tuple[float, float]]:
    """Each constant's unit and its size: the unit is the size itself or, for the rig, its prior's width."""
    p = view.physics
    own = {"A": p.A, "B": p.B, "C": p.C, "D": max(p.D, scales.damping), "k1": p.k1}
    rig = {
        "mass": p.mass,
        "stiffness": p.stiffness,
        "drive_stiffness": p.drive_stiffness,
        "damping": scales.damping,
        "drive_damping": scales.damping,
    }
    return {name: (size, size) for name, size in own.items()} | {
        name: (RIG_PRIOR[name] * size, size) for name, size in rig.items()
    }


def _perturbed(view: Acting, name: str, change: float) -> Acting:
    physics = replace(view.physics, **{name: getattr(view.physics, name) + change})
    return replace(view, physics=physics, record=physics.record())


def _without_states(local: Floats, everything: Floats) -> tuple[Floats, Floats]:
    """Projects each window's initial state out of residual and derivatives.

    local: (windows, values, 3) in units of the states' own size, everything: (windows, values, 1 + unknowns).
    """
    square = np.einsum("wvi,wvj->wij", local, local) + np.eye(local.shape[-1])
    weight = np.linalg.solve(square, np.einsum("wvi,wvk->wik", local, everything))
    left = everything - np.einsum("wvi,wik->wvk", local, weight)
    left = left.reshape(-1, left.shape[-1])
    return left[:, 0], left[:, 1:]
