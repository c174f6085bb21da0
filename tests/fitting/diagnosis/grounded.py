"""Small data sets laid out for a diagnosis, and refits of single effects to them."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.laying import lay_whole
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.lanes.wander import LEAST, OWN, START
from fitting.diagnosis.noise.ground import Ground, ground
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.which.screen import Screen, screen
from fitting.problem import Problem, pose
from fitting.progress import Silent
from fitting.settings import Settings
from jaxstick.effect import AbstractEffect
from jaxstick.effects.asymmetric_friction import AsymmetricFriction
from jaxstick.parts.drive import SineDrive
from jaxstick.record import AssumedConstants, DataSet, Noise, Run
from tests.fitting.reference_data import NOISE, RIGHT, TRUTH, WRONG, dataset, noisy, own_run

WORKERS = 2
SUBSTEPS = 16
UNEVEN = "asymmetric_friction"


def noisy_runs(effects: Mapping[float, Mapping[str, AbstractEffect]], seed: int) -> list[Run]:
    """Noisy runs of the 1987 rig, one at each of these frequencies [Hz], and the effects that act on it."""
    random = np.random.default_rng(seed)
    return [
        noisy(own_run(SineDrive(f, 10.325e-3), effects=dict(own), samples=600, file=f"run-{f}.csv"), random)
        for f, own in effects.items()
    ]


def grounded(effects: dict[str, AbstractEffect], seed: int) -> tuple[Problem, Model, Ground]:
    """Two noisy runs of the 1987 rig on which these effects act, their model and their ground."""
    return grounded_on(noisy_runs(dict.fromkeys((0.9, 2.1), effects), seed))


def grounded_on(runs: Sequence[Run]) -> tuple[Problem, Model, Ground]:
    """Runs of the 1987 rig, their model and their ground."""
    settings = Settings(workers=WORKERS)
    problem = pose(dataset(*runs, assumed=WRONG), settings)
    model = Model(problem, settings.workers)
    return problem, model, ground(problem, model, settings, Silent())


def with_effect(model: Model, base: Ground, nominal: Refit, key: str) -> Refit:
    """The nominal model's refit with an effect of the shelf let free."""
    point = dataclasses.replace(nominal.point, keys=model.sharing.together((key,)))
    (found,) = refit(model, base.bench, [point], [np.concatenate([nominal.free, model.of(key)])])
    return found


class Screened(NamedTuple):
    """A screening, and the refit of the nominal model, its friction not wandering, that it was made at."""

    model: Model
    bench: Bench
    fit: Refit
    seen: Screen


@functools.cache
def screened(times: float = 1.0, dry: float = 0.0) -> Screened:
    """The screening of some effects of friction on a run of the 1987 rig whose noise is so many times the
    usual one and whose dry friction differs by this share between the directions."""
    assert NOISE.displacement is not None and NOISE.friction is not None
    noise = Noise(times * NOISE.displacement, times * NOISE.friction)
    exact = own_run(SineDrive(1.5, 10.325e-3), effects={UNEVEN: AsymmetricFriction(dry, 0.0)}, samples=600)
    model, bench = laid_out(dataset(noisy(exact, np.random.default_rng(4), noise), noise=noise))
    fit = from_the_truth(model, bench, model.sharing.together((UNEVEN,)), model.origin(TRUTH))
    return Screened(model, bench, fit, screen(model, bench, fit, own_group=True, shapes=[]))


def laid_out(stated: DataSet) -> tuple[Model, Bench]:
    """The model of a data set and all its runs as lanes, without a search for constants."""
    problem = pose(stated, Settings(workers=WORKERS))
    return Model(problem, WORKERS), lay_whole(problem, SUBSTEPS)


def from_the_truth(model: Model, bench: Bench, keys: tuple[str, ...], coordinates: np.ndarray) -> Refit:
    """The constants fitted from these coordinates on, friction not wandering."""
    own, widths = np.asarray(bench.lanes.start), np.full(OWN - START, LEAST)
    point = Point(keys, coordinates, model.alike(bench.runs), own, widths)
    (fit,) = refit(model, bench, [point], [model.index(*model.constants)], wander=False)
    return fit


def fitted_from_the_truth(samples: int, assumed: AssumedConstants = RIGHT) -> tuple[Model, Bench, Refit]:
    """A noisy record of the 1987 rig, its lanes fitted from the true constants on."""
    run = noisy(own_run(SineDrive(1.5, 10.325e-3), samples=samples), np.random.default_rng(3))
    model, bench = laid_out(dataset(run, assumed=assumed))
    return model, bench, from_the_truth(model, bench, (), model.origin(TRUTH))
