"""A data set small enough to be fitted in seconds: two short runs of the rig of 1987, with noise."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from jaxstick.record import AssumedConstants, DataSet, KnownRig, Noise, RigSheet, Run, RunPlan
from jaxstick.simulations import simulations

RIG = KnownRig(2.38, 1986.0, 1986.0, 4.53, 0.0)
TRUE = AssumedConstants(1.05, 100.0, 6.42, 0.002, 99300.0)
ASSUMED = AssumedConstants(1.49, 80.0, 5.6, 0.003, 149000.0)
NOISE = Noise(displacement=8e-6, friction=0.03)


def tiny_dataset() -> DataSet:
    """Two and a half cycles at 1.5 and 0.9 Hz with the true constants; the assumed ones are off."""
    plans = tuple(
        RunPlan(
            file=file,
            frequency=frequency,
            base_amplitude=10.325e-3,
            cycles=2.5,
            sample_rate=250.0,
            rig=RIG,
            assumed=TRUE,
        )
        for file, frequency in (("run-01.csv", 1.5), ("more/run-02.csv", 0.9))
    )
    sheet = RigSheet(
        path=Path("rig.toml"),
        name="tiny",
        rig=RIG,
        assumed=TRUE,
        noise=NOISE,
        runs=plans,
        notices=(),
        sha256="0",
    )
    random = np.random.default_rng(1987)
    runs = recorded(simulations(sheet).runs, random)
    return DataSet(name="tiny", rig=RIG, assumed=ASSUMED, noise=NOISE, runs=runs)


def recorded(simulated: Iterable[Run], random: np.random.Generator) -> tuple[Run, ...]:
    """Simulated runs with the noise of `NOISE`, as recorded by one who assumes `ASSUMED`."""
    runs = []
    for run in simulated:
        assert run.friction is not None and NOISE.displacement is not None and NOISE.friction is not None
        displacement = run.displacement + NOISE.displacement * random.standard_normal(len(run.time))
        friction = run.friction + NOISE.friction * random.standard_normal(len(run.time))
        runs.append(dataclasses.replace(run, displacement=displacement, friction=friction, assumed=ASSUMED))
    return tuple(runs)
