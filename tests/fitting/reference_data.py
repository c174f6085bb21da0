"""Data sets whose truth is known: made by the independent reference, or by jaxstick for what only it has."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from jaxstick.effect import AbstractEffect
from jaxstick.hypothesis import Hypothesis
from jaxstick.nominal import nominal
from jaxstick.oscillator import Start
from jaxstick.parts.drive import SineDrive
from jaxstick.record import AssumedConstants, DataSet, KnownRig, Noise, Run
from jaxstick.simulate import simulate
from tests.reference import loaded, rig1987

RIG = KnownRig(rig1987.MASS, rig1987.STIFFNESS, rig1987.STIFFNESS, rig1987.DAMPING, 0.0)
REFERENCE = rig1987.rig()
TRUTH = {name: float(getattr(REFERENCE, name)) for name in ("A", "B", "C", "D", "k1")}
RIGHT = AssumedConstants(**TRUTH)
WRONG = AssumedConstants(A=3 * TRUTH["A"], B=TRUTH["B"] / 3, C=3 * TRUTH["C"], D=0.006, k1=TRUTH["k1"] / 3)
NOISE = Noise(displacement=8e-6, friction=0.03)
RATE = 500.0
DURATION = 2.6
RATIOS = (0.326, 0.190)


@functools.cache
def exact_run(ratio: float) -> Run:
    """One run of the 1987 rig as the reference computes it, after a first second; without noise."""
    drive = rig1987.drive(ratio)
    skipped = round(RATE)
    times = np.arange(skipped + round(DURATION * RATE)) / RATE
    motion = loaded.simulate(REFERENCE, drive, times, tolerance=1e-9)
    base = np.array([drive.position(t) for t in times[skipped:]])
    return Run(
        file=f"ratio-{ratio}.csv",
        time=times[skipped:] - times[skipped],
        displacement=motion.x[skipped:],
        friction=motion.F[skipped:],
        base=base,
        frequency=drive.frequency,
        base_amplitude=drive.base_amplitude,
        rig=RIG,
        assumed=RIGHT,
    )


def noisy(run: Run, random: np.random.Generator, noise: Noise = NOISE) -> Run:
    """The run with noise on displacement and friction."""
    assert run.friction is not None and noise.displacement is not None and noise.friction is not None
    count = len(run.time)
    return dataclasses.replace(
        run,
        displacement=run.displacement + noise.displacement * random.standard_normal(count),
        friction=run.friction + noise.friction * random.standard_normal(count),
    )


def dataset(
    *runs: Run, rig: KnownRig = RIG, assumed: AssumedConstants = RIGHT, noise: Noise = NOISE
) -> DataSet:
    """These runs as a data set of one rig with the stated noise."""
    runs = tuple(dataclasses.replace(run, rig=rig, assumed=assumed) for run in runs)
    return DataSet(name="synthetic", rig=rig, assumed=assumed, noise=noise, runs=runs)


def own_run(
    drive: SineDrive,
    *,
    rig: KnownRig = RIG,
    constants: AssumedConstants | None = None,
    effects: dict[str, AbstractEffect] | None = None,
    samples: int = 1000,
    settling: float = 0.5,
    file: str = "own.csv",
) -> Run:
    """A run simulated by jaxstick from rest with the true constants, or others, and these effects, without
    noise; the record begins after `settling` [s]."""
    oscillator = Hypothesis(nominal(rig, constants or RIGHT, drive), effects or {}).oscillator()
    skipped = round(settling * RATE)
    motion = simulate(oscillator, samples=skipped + samples, interval=1 / RATE, start=Start())
    time = np.asarray(motion.time)
    seen = drive.at(time)
    return Run(
        file=file,
        time=time[:samples],
        displacement=np.asarray(motion.displacement)[skipped:],
        friction=np.asarray(motion.friction)[skipped:],
        base=np.asarray(seen.y)[skipped:] if np.any(seen.y) else None,
        force=np.asarray(seen.u)[skipped:] if np.any(seen.u) else None,
        rig=rig,
        assumed=RIGHT,
    )
