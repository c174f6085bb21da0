"""Small data sets laid out for a diagnosis, and refits of single effects to them."""

from __future__ import annotations

import dataclasses

import numpy as np

from fitting.diagnosis.ground import Ground, ground
from fitting.diagnosis.model import Model
from fitting.diagnosis.refit import Refit, refit
from fitting.problem import Problem, pose
from fitting.progress import Silent
from fitting.settings import Settings
from jaxstick.effect import AbstractEffect
from jaxstick.parts.drive import SineDrive
from tests.fitting.reference_data import WRONG, dataset, noisy, own_run

WORKERS = 2


def grounded(effects: dict[str, AbstractEffect], seed: int) -> tuple[Problem, Model, Ground]:
    """Two noisy runs of the 1987 rig on which these effects act, their model and their ground."""
    random = np.random.default_rng(seed)
    runs = [
        noisy(
            own_run(SineDrive(f, 10.325e-3), effects=dict(effects), samples=600, file=f"run-{f}.csv"), random
        )
        for f in (0.9, 2.1)
    ]
    settings = Settings(workers=WORKERS)
    problem = pose(dataset(*runs, assumed=WRONG), settings)
    model = Model(problem, settings.workers)
    return problem, model, ground(problem, model, settings, Silent())


def with_effect(model: Model, base: Ground, nominal: Refit, key: str) -> Refit:
    """The nominal model's refit with an effect of the shelf let free."""
    point = dataclasses.replace(nominal.point, keys=model.together((key,)))
    (found,) = refit(model, base.bench, [point], [np.concatenate([nominal.free, model.of(key)])])
    return found
