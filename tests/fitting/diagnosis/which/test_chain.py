"""Two links of the measuring chain, found in the order in which the signal passes through them."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.correction import correction_of
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.refits.refit import refit
from fitting.diagnosis.which import chain
from fitting.diagnosis.which.chain import on_the_other_side, other_way_round
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.screen import Promise
from fitting.diagnosis.which.survey import nominal_on
from fitting.problem import Problem
from fitting.progress import Silent
from jaxstick.effect import AbstractEffect
from jaxstick.effects.force_clipping import ForceClipping
from jaxstick.effects.mains_hum import MainsHum
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Run
from tests.fitting.diagnosis.grounded import grounded_on
from tests.fitting.reference_data import NOISE, TRUTH, noisy, own_run

NOTHING = np.zeros(0)
PROMISE = Promise("mains_hum", NOTHING, 0.0, NOTHING, 1.0, NOTHING, NOTHING, NOTHING, NOTHING, NOTHING)
assert NOISE.friction is not None
HUM = MainsHum(20 * NOISE.friction, 0.0)
CLIPPING = ForceClipping(0.9, 6.6)


def recorded(effects: dict[str, AbstractEffect]) -> list[Run]:
    """A noisy run on which these effects act, in this order."""
    random = np.random.default_rng(5)
    return [noisy(own_run(SineDrive(2.1, 10.325e-3), effects=effects, samples=1200), random)]


def fitted(effects: dict[str, AbstractEffect]) -> tuple[Problem, Model, Bench, Explanation]:
    """Both effects in the order of the shelf, fitted from where they truly are."""
    problem, model, base = grounded_on(recorded(effects))
    nominal = nominal_on(model, base.bench, base.point)
    coordinates, keys = model.origin(TRUTH), model.sharing.together(tuple(effects))
    for number in np.concatenate([model.of(key) for key in keys]):
        unknown = model.members[number]
        key, _, name = unknown.name.partition(".")
        value = np.clip(getattr(effects[key], name), unknown.lower, unknown.upper)
        coordinates[number] = unknown.to_coordinate(value)
    by_run = coordinates[model.by_run][None]
    point = dataclasses.replace(nominal.point, keys=keys, coordinates=coordinates, by_run=by_run)
    free = np.concatenate([model.nuisances(), *(model.of(key) for key in keys)])
    (found,) = refit(model, base.bench, [point], [free])
    return problem, model, base.bench, Explanation(keys, PROMISE, found)


def test_a_force_that_is_clipped_before_a_hum_comes_to_it_is_found_so():
    problem, model, bench, pair = fitted({"force_clipping": CLIPPING, "mains_hum": HUM})
    assert pair.refit.misfit > 1.5
    (found,) = other_way_round(model, bench, [pair], 1.0)
    assert found.keys == pair.keys and found.refit.misfit < 1.1
    assert found.refit.point.attached == ("mains_hum", "force_clipping")
    assert other_way_round(model, bench, [found], 1.0) == []
    hypothesis = model.at(found.refit.point.coordinates, found.refit.point.attached)
    correction = correction_of(hypothesis, problem.dataset.rig)
    assert list(correction.effects) == ["force_clipping", "mains_hum"]
    assert correction.effects["mains_hum"]["cosine"] == pytest.approx(HUM.cosine, rel=0.05)
    beside = found.refit.showing(model, ("force_delay",)).point.attached
    assert beside.index("mains_hum") < beside.index("force_clipping")


def test_what_leaves_noise_or_is_no_chain_stays_as_it_is():
    _, model, bench, pair = fitted({"mains_hum": HUM, "force_clipping": CLIPPING})
    assert pair.refit.misfit < 1.1
    assert other_way_round(model, bench, [pair], 1.0) == []
    assert other_way_round(model, bench, [pair], 0.5) == []
    friction = dataclasses.replace(pair, keys=("asymmetric_friction", "mains_hum"))
    assert other_way_round(model, bench, [friction], 0.5) == []


@dataclasses.dataclass(frozen=True)
class Fit:
    """Where it stands."""

    point: Point


def test_links_are_tried_on_the_other_side_of_the_one_that_is_known(monkeypatch):
    """As a hysteresis was found before the hum that comes to the force behind it, in a sealed case, where one
    that the hum goes through showed nothing."""
    whole, links = ("clip", "hum", "delay", "friction"), ("clip", "hum", "delay")
    effects = {key: SimpleNamespace(on_chain=lambda key=key: key in links) for key in whole}
    model: Any = SimpleNamespace(sharing=SimpleNamespace(whole=whole), shelf=SimpleNamespace(effects=effects))
    asked: list[Any] = []

    def contest(model: Any, bench: Any, begin: Any, promises: Any, finalists: int, progress: Any) -> Any:
        asked.append((begin.point.arranged(whole), [promise.key for promise in promises]))
        pair = dataclasses.replace(begin.point, keys=("clip", "hum"))
        return [Explanation(("hum", "clip"), PROMISE, dataclasses.replace(begin, point=pair))]

    monkeypatch.setattr(chain, "contest", contest)
    monkeypatch.setattr(chain, "freed", lambda model, bench, found: found)
    fit: Any = Fit(Point(("clip", "hum", "delay"), NOTHING, NOTHING, NOTHING, NOTHING))
    bench: Any = None
    around: Any = SimpleNamespace(ranked=[SimpleNamespace(key=key) for key in ("friction", "delay", "clip")])
    (found,) = on_the_other_side(model, bench, Explanation(("hum",), PROMISE, fit), around, Silent())
    assert asked == [(("delay", "hum", "clip", "friction"), ["delay", "clip"])]
    assert found.refit.point.turned == found.refit.point.attached == ("hum", "clip")
    assert on_the_other_side(model, bench, Explanation(("friction",), PROMISE, fit), around, Silent()) == []
    around.ranked = around.ranked[:1]
    assert on_the_other_side(model, bench, Explanation(("hum",), PROMISE, fit), around, Silent()) == []
