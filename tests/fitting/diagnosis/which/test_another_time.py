"""Hum beside another effect, which does not repeat itself and is no scatter."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.lanes import model as of_the_model
from fitting.diagnosis.noise.repeatability import floor_of
from fitting.diagnosis.which import another_time
from fitting.diagnosis.which.another_time import in_another_time
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.screen import Promise
from fitting.diagnosis.which.survey import nominal_on
from fitting.progress import Silent
from jaxstick.catalogue import catalogue
from jaxstick.effects.force_delay import ForceDelay
from jaxstick.effects.mains_hum import MainsHum
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Run
from tests.fitting.diagnosis.grounded import grounded_on, with_effect
from tests.fitting.reference_data import NOISE, noisy, own_run

DELAY = ForceDelay(3e-3)
SHELF = ("force_delay", "mains_hum", "force_lowpass", "frictional_memory", "constant_force", "end_stop")
NOTHING = np.zeros(0)
PROMISE = Promise("force_delay", NOTHING, 0.0, NOTHING, 1.0, NOTHING, NOTHING, NOTHING, NOTHING, NOTHING)


def hummed(size: float, scatter: float) -> list[Run]:
    """A run of many cycles on which a delay acts, with hum and scatter of so many times its noise."""
    assert NOISE.friction is not None
    random = np.random.default_rng(5)
    hum = MainsHum(size * NOISE.friction, 0.0)
    run = own_run(SineDrive(2.1, 10.325e-3), effects={"force_delay": DELAY, "mains_hum": hum}, samples=2000)
    run = noisy(run, random)
    assert run.friction is not None
    more = scatter * NOISE.friction * random.standard_normal(len(run.friction))
    return [dataclasses.replace(run, friction=run.friction + more)]


@pytest.mark.parametrize(("size", "scatter", "found"), [(12.0, 0.0, True), (0.0, 8.0, False)])
def test_a_hum_is_found_and_scatter_is_left_alone(monkeypatch, size: float, scatter: float, found: bool):
    monkeypatch.setattr(of_the_model, "catalogue", lambda: {key: catalogue()[key] for key in SHELF})
    _, model, base = grounded_on(hummed(size, scatter))
    nominal = nominal_on(model, base.bench, base.point)
    best = Explanation(("force_delay",), PROMISE, with_effect(model, base, nominal, "force_delay"))
    assert floor_of(model, base.bench, [best.refit]) > 10
    tried = []
    plain = another_time.contest
    monkeypatch.setattr(another_time, "contest", lambda *given: tried.append(given) or plain(*given))
    two = in_another_time(model, base.bench, best, [], Silent())
    assert (two is not None) == bool(tried) == found
    if two is not None:
        assert set(two.keys) == {"force_delay", "mains_hum"}
        assert floor_of(model, base.bench, [two.refit]) < 1.2
