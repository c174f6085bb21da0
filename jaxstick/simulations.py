"""The runs of a data set, or those that a rig.toml lists, as the assumed constants predict them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.hypothesis import Hypothesis
from jaxstick.nominal import effects_of, nominal
from jaxstick.oscillator import Oscillator, Start
from jaxstick.parts.drive import AbstractDrive, RecordedDrive, SineDrive
from jaxstick.precision import float64
from jaxstick.record import AssumedConstants, DataSet, KnownRig, RigSheet, Run, RunPlan
from jaxstick.side_by_side import Journey, side_by_side

CYCLES = 10.0
SAMPLES_PER_CYCLE = 200
SAMPLES_PER_NATURAL_PERIOD = 100
MOST_SAMPLES = 20_000_000


@float64
def simulations(source: DataSet | RigSheet) -> DataSet:
    """The runs of `source` simulated with the assumed constants and the stated effects.

    The result is a data set of the same rig, without noise.

    A run that was recorded is driven as recorded, sampled alike, and begins as its first samples do. A run
    that is only listed begins at rest at time 0 under the stated sine and lasts as stated, else 10 cycles; it
    is sampled as stated, else 200 times a cycle and 100 times a natural period at least.

    Raises UserError for a listed run without frequency or base amplitude, for constants that a simulation
    needs and [assumed] lacks, for effects that `effects_as_stated` refuses, for no runs at all, and for more
    samples or steps than can be handled.
    """
    effects = effects_of(source)
    if isinstance(source, DataSet):
        journeys = [_of_record(run, effects) for run in source.runs]
        blanks = source.runs
    else:
        if not source.runs:
            raise UserError(
                f"{source.path}: no run is listed; a simulation needs [[run]] with frequency_hz and "
                "base_amplitude_mm."
            )
        journeys = [_of_plan(plan, source, effects) for plan in source.runs]
        blanks = tuple(_blank(plan, journey) for plan, journey in zip(source.runs, journeys, strict=True))
    trajectories = side_by_side(journeys)
    runs = tuple(
        replace(
            blank,
            displacement=np.asarray(trajectory.displacement),
            friction=np.asarray(trajectory.friction),
            base=_base(blank),
            velocity=None,
        )
        for blank, trajectory in zip(blanks, trajectories, strict=True)
    )
    return DataSet(
        name=source.name, rig=source.rig, assumed=source.assumed, effects=source.effects, runs=runs
    )


def _of_record(run: Run, effects: Mapping[str, AbstractEffect]) -> Journey:
    oscillator = _oscillator(run.file, run.rig, run.assumed, _drive(run), effects)
    return Journey(oscillator, _start(run, oscillator), float(run.time[0]), run.interval, len(run.time))


def _of_plan(plan: RunPlan, sheet: RigSheet, effects: Mapping[str, AbstractEffect]) -> Journey:
    where = f"{sheet.path}: the run {plan.file}"
    if plan.frequency is None:
        raise UserError(f"{where} has no frequency_hz, which a simulation needs where there is no record.")
    if plan.base_amplitude is None:
        raise UserError(
            f"{where} has no base_amplitude_mm, which a simulation needs where there is no record."
        )
    natural = plan.rig.natural_frequency
    rate = plan.sample_rate or max(SAMPLES_PER_CYCLE * plan.frequency, SAMPLES_PER_NATURAL_PERIOD * natural)
    cycles = CYCLES if plan.cycles is None else plan.cycles
    duration = cycles / plan.frequency if plan.duration is None else plan.duration
    if duration * rate > MOST_SAMPLES:
        raise UserError(
            f"{where} would have {duration * rate:.3g} samples; at most {MOST_SAMPLES:.0e} can be simulated."
        )
    if duration * rate < 1:
        raise UserError(f"{where} lasts {duration:g} s, less than one interval at {rate:g} samples a second.")
    drive = SineDrive(plan.frequency, plan.base_amplitude, phase=plan.base_phase)
    oscillator = _oscillator(f"{where}", plan.rig, plan.assumed, drive, effects)
    return Journey(oscillator, Start(), 0.0, 1 / rate, round(duration * rate) + 1)


def _oscillator(
    where: str,
    rig: KnownRig,
    assumed: AssumedConstants,
    drive: AbstractDrive,
    effects: Mapping[str, AbstractEffect],
) -> Oscillator:
    try:
        return Hypothesis(nominal(rig, assumed, drive), dict(effects)).oscillator()
    except UserError as error:
        raise UserError(f"{where}: {error}") from error


def _blank(plan: RunPlan, journey: Journey) -> Run:
    """A run that has its times but no record yet."""
    time = np.asarray(journey.interval * np.arange(journey.samples), np.float64)
    return Run(
        file=plan.file,
        time=time,
        displacement=np.zeros_like(time),
        frequency=plan.frequency,
        base_amplitude=plan.base_amplitude,
        base_phase=plan.base_phase,
        hold_out=plan.hold_out,
        rig=plan.rig,
        assumed=plan.assumed,
    )


def _sine(run: Run) -> np.ndarray | None:
    """The base as stated, at the samples [m]; None where it is not stated."""
    if run.frequency is None or run.base_amplitude is None:
        return None
    return run.base_amplitude * np.sin(2 * math.pi * run.frequency * run.time + run.base_phase)


def _drive(run: Run) -> AbstractDrive:
    if run.base is None and run.force is None:
        return SineDrive(run.frequency or 0.0, run.base_amplitude or 0.0, phase=run.base_phase)
    base = _sine(run) if run.base is None else run.base
    return RecordedDrive.through(float(run.time[0]), run.interval, base, run.force)


def _base(run: Run) -> np.ndarray | None:
    """The base as its channel shows it, at the samples [m]; None where only a force drove the simulation."""
    if run.base is not None:
        return run.base
    stated = _sine(run)
    return None if stated is None else np.asarray(_drive(run).at(run.time).y)


def _start(run: Run, oscillator: Oscillator) -> Start:
    """The state at the first sample: displacement and velocity from a parabola through the first 25th of a
    natural period, the friction force as recorded there, else what the equation of motion asks for."""
    natural = run.rig.natural_frequency
    few = max(7, round(0.04 / (natural * run.interval))) if natural else 7
    few = min(few, len(run.time))
    elapsed = run.time[:few] - run.time[0]
    coefficients = np.polynomial.Polynomial.fit(elapsed, run.displacement[:few], min(2, few - 1))
    x, v = (float(p(0.0)) for p in (coefficients, coefficients.deriv()))
    if run.friction is not None:
        return Start(x, v, float(run.friction[0]))
    a = float(coefficients.deriv(2)(0.0))
    motion = oscillator.motion(run.time[0], oscillator.drive.at(run.time[0]), x, v, a)
    others = oscillator.rig.force(oscillator.rig.initial(motion), motion)
    return Start(x, v, float(oscillator.rig.inertia() * a - others))
