"""The motion of a case: what happens, and what ideal or real sensors make of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fitting.blind.formulation import Floats, RunFacts, Signals
from fitting.blind.march import march, start_state
from fitting.blind.menu import formulation
from fitting.blind.noise import remembering
from fitting.blind.physics import Physics
from fitting.blind.recipe import Chosen, Recipe, RunPlan

OVERSAMPLING = 8
"""Readings per sample that the sensors see."""

TAIL = 1
"""Samples that the motion goes on after the record's end."""

FINE = 20
COARSE = 1
"""Steps per reading: of the truth, 160 a sample, on which a force that is read as sharply as friction breaks
away is off by less than the noise can tell (on 40 a sample it was off by up to 800 of chi-square in 8000
samples); and where only its gap is estimated."""


@dataclass(frozen=True)
class Acting:
    """What moves one run: compiled constants, elements, the factor on friction over time."""

    physics: Physics
    record: NDArray[np.void]
    elements: Floats
    series: Floats
    start: float
    interval: float


def run_facts(recipe: Recipe, index: int) -> RunFacts:
    """What effects may know of the run."""
    return RunFacts(index, recipe.runs[index].samples * recipe.interval)


def acting(recipe: Recipe, index: int, effects: Sequence[Chosen], seen: bool = False) -> Acting:
    """The physics of one run with these effects; `seen`: with the drive that the records show."""
    plan, facts = recipe.runs[index], run_facts(recipe, index)
    physics = driven(recipe, plan)
    elements = recipe.elements
    start = -plan.settling * recipe.interval
    count = plan.settling + plan.samples + TAIL + 2
    time = np.asarray(start + recipe.interval * np.arange(count), dtype=np.float64)
    series = _scatter(recipe, index, count)
    for chosen in effects:
        effect = formulation(chosen.key, chosen.version)
        physics = effect.physics(physics, chosen.strength, chosen.shape, facts)
        elements = effect.elements(elements, chosen.strength, chosen.shape)
        series = effect.series(series, time, chosen.strength, chosen.shape, facts)
    if seen:
        physics = seen_drive(recipe, index, physics)
    return Acting(physics, physics.record(), elements.array(), series, start, recipe.interval)


def seen_drive(recipe: Recipe, index: int, physics: Physics) -> Physics:
    """The physics with the drive that the records show."""
    facts = run_facts(recipe, index)
    for chosen in recipe.effects:
        physics = formulation(chosen.key, chosen.version).drive(physics, chosen.strength, chosen.shape, facts)
    return physics


def driven(recipe: Recipe, plan: RunPlan) -> Physics:
    """The rig with the drive and the level of friction of one run."""
    return replace(
        recipe.physics,
        amplitude=plan.amplitude,
        omega=2.0 * np.pi * plan.frequency,
        phase=plan.phase,
        level=plan.level,
    )


def _scatter(recipe: Recipe, index: int, count: int) -> Floats:
    """1 + an Ornstein-Uhlenbeck process."""
    if recipe.scatter == 0.0:
        return np.ones(count)
    white = np.random.default_rng([recipe.seed, index, 1]).standard_normal(count)
    return 1.0 + recipe.scatter * remembering(white, float(np.exp(-recipe.interval / recipe.scatter_time)))


def initial_state(run: Acting) -> Floats:
    """The state in which settling begins: at rest where the springs would hold the mass."""
    p = run.physics
    y = p.amplitude * np.sin(p.omega * run.start + p.phase)
    return start_state(run.record, p.drive_stiffness / p.stiffness * y, 0.0, run.start)


def moved(run: Acting, state: Floats, start: float, readings: int, fineness: int) -> Floats:
    """The run from `state` at `start` [s] on: (readings, 5), see `march`; the state moves on."""
    out = np.empty((readings, 5))
    step = run.interval / (OVERSAMPLING * fineness)
    march(
        run.record,
        run.elements,
        run.series,
        run.start,
        run.interval,
        state,
        start,
        step,
        fineness,
        readings,
        out,
        fineness > COARSE,
    )
    return out


def signals_of(run: Acting, moved_rows: Floats) -> Signals:
    """The channels that perfect sensors would show, of rows that begin one reading after the start."""
    step = run.interval / OVERSAMPLING
    time = np.asarray(run.start + step * np.arange(1, len(moved_rows) + 1), dtype=np.float64)
    p = run.physics
    velocity = moved_rows[:, 1]
    return Signals(
        time=time,
        step=step,
        displacement=moved_rows[:, 0],
        velocity=velocity,
        acceleration=np.gradient(velocity, step),
        friction=moved_rows[:, 2],
        base=p.amplitude * np.sin(p.omega * time + p.phase),
    )


def sense(recipe: Recipe, index: int, effects: Sequence[Chosen], signals: Signals) -> Signals:
    """The channels after the sensors' effects."""
    for chosen in effects:
        effect = formulation(chosen.key, chosen.version)
        effect.chain(signals, chosen.strength, chosen.shape, run_facts(recipe, index))
    return signals


def noise_free(recipe: Recipe, index: int, with_effects: bool = True) -> Signals:
    """The channels of one run as the sensors give them before converter and noise, from the settling on.

    Without effects: the same rig, scatter and start, but nothing of the case's effects.
    """
    effects = recipe.effects if with_effects else ()
    plan = recipe.runs[index]
    run = acting(recipe, index, effects)
    readings = (plan.settling + plan.samples + TAIL) * OVERSAMPLING
    rows = moved(run, initial_state(run), run.start, readings, FINE)
    return sense(recipe, index, effects, signals_of(run, rows))
