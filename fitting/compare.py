"""Identified constants against assumed ones: the numbers, and what they do to the motion of every run."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from fitting.against import against
from fitting.saved import SavedFit, SavedRun
from fitting.unknowns import RIG
from jaxstick.cycle import Cycle, cycle_of, outcome_of
from jaxstick.effect import AbstractEffect
from jaxstick.hypothesis import Hypothesis, effects_as_stated, effects_at_null
from jaxstick.nominal import effects_of, nominal
from jaxstick.oscillator import Oscillator, Start
from jaxstick.outcome import Outcome, outcome
from jaxstick.parameter import replace
from jaxstick.parts.drive import SineDrive
from jaxstick.precision import float64
from jaxstick.record import CONSTANTS, AssumedConstants, DataSet, KnownRig, RigSheet
from jaxstick.side_by_side import Journey, side_by_side

OTHERS = "others"
"""The name under which all else that was fitted (effects, freed rig parameters) is exchanged at once."""

LOOKED_AT = 4
SETTLING_PERIODS = 25.0
LEAST_CYCLES, MOST_CYCLES = 6, 100
RESOLUTION = 100.0
SAMPLES_PER_CYCLE = (200, 3000)
SAMPLES_PER_NATURAL_PERIOD = 40


@dataclasses.dataclass(frozen=True)
class RunComparison:
    """One run's periodic motion: as measured (None where it was not), with the assumed constants, with the
    identified ones, and with the assumed ones but for one, by that one's name (None where [assumed] lacks a
    constant that a simulation needs)."""

    file: str
    cycle: Cycle
    natural_frequency: float
    measured: Outcome | None
    assumed: Outcome | None
    identified: Outcome
    exchanged: dict[str, Outcome] | None


@dataclasses.dataclass(frozen=True)
class Comparison:
    """Entries of the constants as `against` makes them, the runs, and sentences on what was left out."""

    constants: dict[str, dict[str, Any]]
    others: dict[str, dict[str, Any]]
    runs: tuple[RunComparison, ...]
    notices: tuple[str, ...]


@float64
def compare(saved: SavedFit, source: DataSet | RigSheet | None = None) -> Comparison:
    """Compares a fit with the constants assumed in `source`, or in the data set it was made from.

    Runs, rig, assumed constants and the effects assumed with them are those of `source` where it is given.
    The identified constants go with the effects of the fit. Every run driven by one sine is
    marched from rest, with both sets of constants and with each constant exchanged alone, until its
    transient is gone; the last four cycles count.

    Raises UserError for effects that `effects_as_stated` refuses.
    """
    held = effects_as_stated(saved.effects, saved.path)
    assumed = held if source is None else effects_of(source)
    runs = saved.runs if source is None else _runs(source)
    stated = saved.assumed if source is None else source.assumed
    base_rig = saved.rig if source is None else source.rig
    constants = {name: against(entry, getattr(stated, name)) for name, entry in saved.constants.items()}
    others = {name: against(entry, entry["assumed"]) for name, entry in saved.others.items()}
    notices = []
    driven = [(run, run.cycle) for run in runs if run.cycle is not None]
    if len(driven) < len(runs):
        files = ", ".join(run.file for run in runs if run.cycle is None)
        notices.append(f"{files}: not driven by one sine whose frequency and amplitude are known; left out.")
    if any(getattr(run.assumed, name) is None for run, _ in driven for name in ("C", "k1")):
        notices.append(
            "C or k1 is not assumed, so there is no motion with the assumed constants to compare with."
        )
    cases = [(run, cycle, _cases(saved, run, cycle, base_rig, held, assumed)) for run, cycle in driven]
    found = iter(_outcomes([(run, cycle, each) for run, cycle, case in cases for each in case.values()]))
    compared = []
    for run, cycle, case in cases:
        outcomes = {name: next(found) for name in case}
        compared.append(
            RunComparison(
                run.file,
                cycle,
                run.rig.natural_frequency,
                run.measured,
                outcomes.pop("assumed", None),
                outcomes.pop("identified"),
                outcomes or None,
            )
        )
    return Comparison(constants, others, tuple(compared), tuple(notices))


def _runs(source: DataSet | RigSheet) -> tuple[SavedRun, ...]:
    if isinstance(source, DataSet):
        return tuple(
            SavedRun(run.file, cycle_of(run), run.rig, run.assumed, outcome_of(run)) for run in source.runs
        )
    plans = []
    for plan in source.runs:
        cycle = None
        if plan.frequency is not None and plan.base_amplitude is not None:
            cycle = Cycle(plan.frequency, plan.base_amplitude, 0.0, plan.base_phase)
        plans.append(SavedRun(plan.file, cycle, plan.rig, plan.assumed, None))
    return tuple(plans)


def _cases(
    saved: SavedFit,
    run: SavedRun,
    cycle: Cycle,
    rig: KnownRig,
    held: Mapping[str, AbstractEffect],
    stated: Mapping[str, AbstractEffect],
) -> dict[str, Oscillator]:
    """The oscillators of one run by name: identified, assumed, and assumed but for one.

    held: the effects that the fit rests on; stated: those that are assumed.
    """
    drive = SineDrive(cycle.frequency, cycle.base_amplitude, cycle.force_amplitude, cycle.phase)
    identified = {name: float(saved.constants[name]["value"]) for name in CONSTANTS}
    others = {name: float(entry["value"]) for name, entry in saved.others.items()}

    def oscillator(
        constants: Mapping[str, float | None],
        changed: Mapping[str, float],
        acting: Mapping[str, AbstractEffect],
    ) -> Oscillator:
        freed = {
            name: getattr(run.rig, name) + value - getattr(rig, name)
            for name, value in (
                (name.removeprefix(RIG), value) for name, value in changed.items() if name.startswith(RIG)
            )
        }
        known = dataclasses.replace(run.rig, **freed)
        fitted = effects_at_null(
            tuple(dict.fromkeys(name.split(".")[0] for name in changed if not name.startswith(RIG)))
        )
        effects = {**acting, **{key: effect for key, effect in fitted.items() if key not in acting}}
        for key in fitted:
            own = {name.split(".")[1]: value for name, value in changed.items() if name.startswith(f"{key}.")}
            effects[key] = replace(effects[key], own)
        return Hypothesis(nominal(known, AssumedConstants(**constants), drive), effects).oscillator()

    cases = {"identified": oscillator(identified, others, held)}
    assumed = dataclasses.asdict(run.assumed)
    if assumed["C"] is not None and assumed["k1"] is not None:
        cases["assumed"] = oscillator(assumed, {}, stated)
        for name in CONSTANTS:
            cases[name] = oscillator({**assumed, name: identified[name]}, {}, stated)
        if others:
            cases[OTHERS] = oscillator(assumed, others, stated)
    return cases


def _outcomes(lanes: list[tuple[SavedRun, Cycle, Oscillator]]) -> list[Outcome]:
    """The periodic motion of every lane: marched from rest over as many cycles as the slowest transient asks
    for, in one program."""
    if not lanes:
        return []
    ratios = [
        cycle.frequency / run.rig.natural_frequency if run.rig.natural_frequency else 1.0
        for run, cycle, _ in lanes
    ]
    cycles = LOOKED_AT + min(max(LEAST_CYCLES, math.ceil(SETTLING_PERIODS * max(ratios))), MOST_CYCLES)
    least, most = SAMPLES_PER_CYCLE
    per_cycle = min(max(least, math.ceil(SAMPLES_PER_NATURAL_PERIOD / min(ratios))), most)
    journeys = [
        Journey(oscillator, Start(), 0.0, 1 / (cycle.frequency * per_cycle), cycles * per_cycle)
        for _, cycle, oscillator in lanes
    ]
    return [
        outcome(
            np.asarray(trajectory.displacement),
            interval=1 / (cycle.frequency * per_cycle),
            frequency=cycle.frequency,
            natural_frequency=run.rig.natural_frequency,
            cycles=LOOKED_AT,
        )
        for trajectory, (run, cycle, _) in zip(side_by_side(journeys, RESOLUTION), lanes, strict=True)
    ]
