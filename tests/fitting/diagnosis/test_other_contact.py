"""When a contact takes the place of an effect that changes it, beside another effect."""

from __future__ import annotations

import dataclasses
import types
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis import other_contact
from fitting.diagnosis.bench import Point
from fitting.diagnosis.explanation import Explanation
from fitting.diagnosis.other_contact import beside_single_effects, in_place_of_one_of_two
from fitting.diagnosis.refit import Refit
from fitting.diagnosis.screen import Promise
from fitting.diagnosis.shrink import Split
from fitting.diagnosis.survey import Survey
from fitting.progress import Silent
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import laid_out
from tests.fitting.reference_data import dataset, own_run

NOBODY = np.zeros(0)
HELD = Split(np.arange(3), np.arange(3, 4), ())
HUM, SLIP, DELAY = "mains_hum", "microslip", "force_delay"


@pytest.fixture(scope="module")
def paper() -> Any:
    """The paper's contact, with a model of its own."""
    model, _ = laid_out(dataset(own_run(SineDrive(0.9, 10.325e-3), samples=600)))
    return types.SimpleNamespace(model=model, words=None)


@dataclasses.dataclass
class Found:
    """What of an attribution counts here."""

    explanations: tuple[Explanation, ...]
    floor: float = 1.0


def explained(*misfits: tuple[tuple[str, ...], float]) -> Any:
    """Explanations that leave these misfits, the best first."""
    blank: Any = None
    point = Point((), NOBODY, NOBODY, NOBODY, NOBODY)
    plain = Refit(*[blank] * len(dataclasses.fields(Refit)))
    promise = Promise(HUM, NOBODY, 1.0, NOBODY, 1.0, NOBODY, NOBODY, NOBODY, NOBODY, NOBODY)
    fits = {keys: dataclasses.replace(plain, point=point, misfit=misfit) for keys, misfit in misfits}
    return Found(tuple(Explanation(keys, promise, fit) for keys, fit in fits.items()))


def settled(paper: Any, monkeypatch: pytest.MonkeyPatch, before: Any, after: Any, words: str | None) -> Any:
    """The contact that is settled on where the one that the records suggest has these words, and the
    explanations refitted on it leave what they leave `after`; and beside which fits it was looked for."""
    asked: list[Any] = []
    suggested = types.SimpleNamespace(model=paper.model, words=words)

    def chosen(
        paper: Any, bench: Any, lanes: Any, fits: Any, floor: float, progress: Any, worth: float
    ) -> Any:
        asked.extend(fits)
        share = (1 - worth) / (1 - before.explanations[0].refit.misfit / fits[0].misfit)
        assert 0 < share <= 0.5 + 1e-9, "a contact that does half of what the effect does is worth trying"
        return suggested

    monkeypatch.setattr(other_contact, "choose_contact", chosen)

    def carried(model: Any, bench: Any, found: Any, other: Any) -> Any:
        """The first few of the explanations there are."""
        there = {e.keys for e in found.explanations[:FEW]}
        return Found(tuple(e for e in after.explanations if e.keys in there))

    monkeypatch.setattr(other_contact, "on_another_contact", carried)
    bench: Any = None
    contact, found = in_place_of_one_of_two(paper, bench, before, HELD, Silent())
    assert (found is before) == (contact is not suggested)
    return contact.words, [fit.misfit for fit in asked]


FEW = 2
"""So many explanations are refitted on another contact; the one effect alone may come later."""
PAIR = explained(((HUM, SLIP), 1.016), ((HUM, DELAY), 1.24), ((HUM,), 1.28), ((SLIP,), 28.0))


@pytest.mark.parametrize(("left", "words"), [(0.99, "a bristle"), (1.2, None)])
def test_one_effect_on_another_contact_takes_the_place_of_two(paper, monkeypatch, left, words):
    """Where it leaves as little as they do; it is looked for beside that effect alone."""
    after = explained(((HUM, SLIP), 0.98), ((HUM,), left))
    assert settled(paper, monkeypatch, PAIR, after, "a bristle") == (words, [1.28])


def test_the_contact_stays_where_no_other_is_suggested(paper, monkeypatch):
    assert settled(paper, monkeypatch, PAIR, PAIR, None) == (None, [1.28])


@pytest.mark.parametrize("keys", [(HUM,), (SLIP,), (HUM, DELAY)])
def test_nothing_is_tried_where_no_one_of_two_changes_the_contact(paper, monkeypatch, keys):
    before = explained((keys, 1.0), *(((key,), 1.3) for key in keys if len(keys) > 1))
    assert settled(paper, monkeypatch, before, before, "a bristle") == (None, [])


@pytest.mark.parametrize(
    ("without", "best", "taken"), [(9.0, 1.5, True), (9.0, 2.6, False), (2.9, 2.8, True), (3.1, 2.8, False)]
)
def test_the_survey_on_another_contact_knows_what_explained_the_records_before(
    paper, monkeypatch, without, best, taken
):
    """Where it stood, carried over: from the nominal model on, the effect may not come among those tried.
    The contact is taken where it leaves clearly less, or does without an effect what the best did."""
    model = paper.model
    point = Point((HUM,), model.origin({}), np.zeros((1, len(model.by_run))), np.zeros((3, 5)), np.ones(2))
    point.coordinates[model.index("A")] = 0.7
    fit = dataclasses.replace(
        PAIR.explanations[0].refit, point=point, free=model.index("A", "mains_hum.sine")
    )
    found = tuple(
        dataclasses.replace(PAIR.explanations[2], refit=dataclasses.replace(fit, misfit=m)) for m in (3.0,)
    )
    blank: Any = None
    seen: Any = Survey(dataclasses.replace(fit, misfit=9.0), blank, found, 1.0)
    ground: Any = types.SimpleNamespace(point=point, begins=NOBODY)
    other: Any = types.SimpleNamespace(model=model, words="a bristle", ground=ground, preferred=0.6)
    monkeypatch.setattr(other_contact, "choose_contact", lambda *_: other)
    told: list[Explanation] = []

    def surveyed(model: Any, bench: Any, nominal: Any, begins: Any, progress: Any, known: Any) -> Any:
        told.extend(known)
        better = dataclasses.replace(known[0], refit=dataclasses.replace(known[0].refit, misfit=best))
        return Survey(nominal, blank, (better,), 1.0)

    bare = dataclasses.replace(seen.nominal, misfit=without)
    monkeypatch.setattr(other_contact, "nominal_on", lambda *_: bare)
    monkeypatch.setattr(other_contact, "survey", surveyed)
    contact, again = beside_single_effects(paper, blank, seen, HELD, Silent())
    assert (contact is other, again.least) == (taken, best if taken else 3.0)
    (carried,) = told
    assert carried.keys == (HUM,) and carried.refit.misfit == 3.0
    assert carried.refit.point.coordinates[model.index("A")] == 0.7
    assert model.index("mains_hum.sine")[0] in carried.refit.free


@pytest.mark.parametrize(("without", "taken"), [(1.1, False), (1.02, True)])
def test_where_an_effect_suffices_another_contact_must_do_without_it(paper, monkeypatch, without, taken):
    """Or nothing is surveyed there."""
    model = paper.model
    point = Point((HUM,), model.origin({}), np.zeros((1, len(model.by_run))), np.zeros((3, 5)), np.ones(2))
    fit = dataclasses.replace(PAIR.explanations[0].refit, point=point, free=model.index("mains_hum.sine"))
    blank: Any = None
    best = dataclasses.replace(PAIR.explanations[2], refit=dataclasses.replace(fit, misfit=1.05))
    seen = Survey(dataclasses.replace(fit, misfit=9.0), blank, (best,), 1.0)
    assert seen.suffices
    ground: Any = types.SimpleNamespace(point=point, begins=NOBODY)
    other: Any = types.SimpleNamespace(model=model, words="a bristle", ground=ground, preferred=0.6)
    bare = dataclasses.replace(fit, misfit=without)
    surveys: list[Survey] = []

    def surveyed(*given: Any) -> Survey:
        surveys.append(Survey(given[2], blank, (best,), 1.0))
        return surveys[-1]

    monkeypatch.setattr(other_contact, "choose_contact", lambda *_: other)
    monkeypatch.setattr(other_contact, "nominal_on", lambda *_: bare)
    monkeypatch.setattr(other_contact, "survey", surveyed)
    found = beside_single_effects(paper, blank, seen, HELD, Silent())
    assert found == ((other, surveys[0]) if taken else (paper, seen)) and len(surveys) == taken
