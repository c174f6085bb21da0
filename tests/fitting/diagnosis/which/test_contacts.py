"""The contact is told from records of which it is the only thing that is not as assumed."""

from __future__ import annotations

import dataclasses
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

from fitting.diagnosis.accounts import Account
from fitting.diagnosis.findings import Yardstick
from fitting.diagnosis.judging.judge import judge
from fitting.diagnosis.lanes.model import Model
from fitting.diagnosis.noise.ground import Ground
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import released
from fitting.diagnosis.which.attribute import Attribution, on_another_contact
from fitting.diagnosis.which.contacts import Chosen, carried, choose_contact
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.screen import screen
from fitting.progress import Silent
from jaxstick.effect import AbstractEffect, Card
from jaxstick.effects.force_gain import ForceGain
from jaxstick.oscillator import Oscillator
from jaxstick.parts.contact import AbstractContact
from jaxstick.parts.gradual import ElastoPlasticContact, LuGreContact
from tests.fitting.diagnosis.grounded import grounded, with_effect
from tests.fitting.reference_data import TRUTH


class OtherContact(AbstractEffect):
    """Another contact in the place of the paper's."""

    card: ClassVar[Card] = Card("", "friction", "", "", "", "")
    contact: AbstractContact

    def attach(self, oscillator: Oscillator) -> Oscillator:
        return dataclasses.replace(oscillator, contact=self.contact)


class Looked(NamedTuple):
    """Two noisy runs with another contact: model, ground, refits of the nominal model and of an effect that
    acts too, and the choice."""

    model: Model
    base: Ground
    fits: list[Refit]
    chosen: Chosen


def looked_at(contact: AbstractContact | None, effect: AbstractEffect | None = None) -> Looked:
    """What is chosen where this contact acts, and an effect of the shelf, beside a refit of which it is
    chosen then."""
    effects: dict[str, AbstractEffect] = {} if contact is None else {"contact": OtherContact(contact)}
    if effect is not None:
        effects["effect"] = effect
    problem, model, base = grounded(effects, 5)
    (nominal,) = refit(model, base.bench, [base.point], [model.nuisances()])
    fits = [nominal]
    if effect is not None:
        (key,) = (key for key, one in model.shelf.effects.items() if isinstance(effect, one))
        fits.append(with_effect(model, base, nominal, key))
    lanes = np.arange(len(base.bench.lanes))
    chosen = choose_contact(Chosen(problem, model, base), base.bench, lanes, fits, 1.0, Silent())
    return Looked(model, base, fits, chosen)


@pytest.mark.parametrize(
    ("contact", "word"),
    [(LuGreContact(TRUTH["k1"]), "LuGre"), (ElastoPlasticContact(TRUTH["k1"], 0.5), "elasto-plastic")],
    ids=["lugre", "elasto-plastic"],
)
def test_a_bristle_is_told_and_leaves_nothing_but_noise(contact, word):
    _, base, (nominal,), chosen = looked_at(contact)
    assert nominal.misfit > 2
    assert chosen.words is not None and word in chosen.words
    assert chosen.ratio < 0.6
    (again,) = refit(chosen.model, base.bench, [chosen.ground.point], [chosen.model.nuisances()])
    again = released(chosen.model, base.bench, again)
    assert again.misfit < 1.3
    found = chosen.model.values(again.point.coordinates, chosen.model.common)
    assert found["k1"] == pytest.approx(TRUTH["k1"], rel=0.03)
    if word == "elasto-plastic":
        assert found["contact.breakaway"] == pytest.approx(0.5, abs=0.05)


def test_constants_that_led_astray_under_the_assumed_contact_do_not_hide_the_one_that_acts():
    """From there elements that yield one after another cost least; the search of the bristle itself does not
    begin there."""
    problem, model, base = grounded({"contact": OtherContact(LuGreContact(TRUTH["k1"]))}, 5)
    far_off = model.origin({**TRUTH, "C": 0.3 * TRUTH["C"], "D": 10 * TRUTH["D"]})
    begin = base.point.at_constants(model, far_off[model.index(*model.constants)])
    (astray,) = refit(model, base.bench, [begin], [model.nuisances()])
    assert astray.misfit > 1000
    lanes = np.arange(len(base.bench.lanes))
    chosen = choose_contact(Chosen(problem, model, base), base.bench, lanes, [astray], 1.0, Silent())
    assert chosen.words is not None and "LuGre" in chosen.words
    found = chosen.model.values(chosen.ground.point.coordinates, model.constants)
    assert found["C"] == pytest.approx(TRUTH["C"], rel=0.01)
    assert found["k1"] == pytest.approx(TRUTH["k1"], rel=0.01)


def test_a_strong_effect_does_not_hide_the_contact():
    """Its own effect is taken away again from the point that the next survey begins at. What was found under
    the paper's contact is fitted once more under the one chosen, and then leaves nothing but noise."""
    model, base, fits, chosen = looked_at(ElastoPlasticContact(TRUTH["k1"], 0.5), ForceGain(0.3))
    nominal, gained = fits
    assert nominal.misfit > 20
    assert chosen.words is not None and "elasto-plastic" in chosen.words
    point = chosen.ground.point
    assert point.keys == ()
    assert chosen.model.values(point.coordinates, ["force_gain.gain"])["force_gain.gain"] == 0
    found = chosen.model.values(point.coordinates, chosen.model.common)
    assert found["contact.breakaway"] == pytest.approx(0.5, abs=0.1)

    groups = (group for group in model.sharing.groups if {"force_gain", "stiffness_error"} & {*group})
    seen = screen(model, base.bench, nominal, only=[key for group in groups for key in group], shapes=[])
    promise = next(p for p in seen.promises if p.key == "force_gain")
    accounts = (Account((promise.key,), gained.misfit, 1),)
    judgement = judge(nominal.misfit, accounts, 1e4, 1.0, seen.keys)
    only = (Explanation((promise.key,), promise, gained),)
    against = Yardstick(nominal.misfit, 1.0, 1e4, 1.0, False, accounts)
    before = Attribution(nominal, only, seen, judgement, against)
    again = on_another_contact(model, base.bench, before, chosen.model)
    assert gained.misfit > 2 and again.explanations[0].refit.misfit < 1.3
    assert again.judgement.named[0] == "force_gain"
    assert set(again.judgement.named) == {"force_gain", "displacement_gain", "stiffness_error"}


def test_the_contact_of_the_paper_is_kept_where_it_fits():
    model, base, (nominal,), chosen = looked_at(None)
    assert chosen.words is None and chosen.model is model and chosen.ground is base
    assert nominal.misfit < 1.2
    same = carried(nominal, model, model)
    assert same.point.coordinates == pytest.approx(nominal.point.coordinates, abs=1e-9)
    assert list(same.free) == list(nominal.free) and same.point.keys == ()
