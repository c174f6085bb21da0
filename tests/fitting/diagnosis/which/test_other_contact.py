"""When a contact takes the place of an effect that changes it, beside another effect."""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.how_far.shrink import Split
from fitting.diagnosis.judging.enough import passes_for_noise
from fitting.diagnosis.lanes.bench import Point
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.which import other_contact
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.other_contact import beside_single_effects, in_place_of_one_of_two
from fitting.diagnosis.which.screen import Promise
from fitting.diagnosis.which.survey import Survey
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


Known = Sequence[Explanation]


def on_the_other(
    paper: Any, monkeypatch: pytest.MonkeyPatch, alone: float, without: float, best: float
) -> tuple[bool, float, list[Known]]:
    """Whether the contact that the records suggest is taken, what then is the lowest misfit, and what every
    survey there knew. One effect leaves `alone` and the nominal model 9 on the paper's contact; on the other
    the nominal model leaves `without`, and the survey finds `best`."""
    model = paper.model
    point = Point((HUM,), model.origin({}), np.zeros((1, len(model.by_run))), np.zeros((3, 5)), np.ones(2))
    point.coordinates[model.index("A")] = 0.7
    fit = dataclasses.replace(
        PAIR.explanations[0].refit, point=point, free=model.index("A", "mains_hum.sine")
    )

    def leaving(misfit: float) -> Refit:
        return dataclasses.replace(fit, misfit=misfit)

    blank: Any = None
    found = dataclasses.replace(PAIR.explanations[2], refit=leaving(alone))
    seen = Survey(leaving(9.0), blank, (found,), 1.0)
    ground: Any = types.SimpleNamespace(point=point, begins=NOBODY)
    other: Any = types.SimpleNamespace(model=model, words="a bristle", ground=ground, preferred=0.6)
    known: list[Known] = []

    def surveyed(
        _model: Any, _bench: Any, nominal: Refit, _begins: Any, _progress: Any, told: Known
    ) -> Survey:
        known.append(told)
        return Survey(nominal, blank, (dataclasses.replace(told[0], refit=leaving(best)),), 1.0)

    monkeypatch.setattr(other_contact, "choose_contact", lambda *_: other)
    monkeypatch.setattr(other_contact, "nominal_on", lambda *_: leaving(without))
    monkeypatch.setattr(other_contact, "survey", surveyed)
    contact, again = beside_single_effects(paper, blank, seen, HELD, Silent())
    assert contact in (other, paper) and (again is seen) == (contact is paper)
    return contact is other, again.least, known


@pytest.mark.parametrize(
    ("without", "best", "taken"), [(9.0, 1.5, True), (9.0, 2.6, False), (2.9, 2.8, True), (3.1, 2.8, False)]
)
def test_the_survey_on_another_contact_knows_what_explained_the_records_before(
    paper, monkeypatch, without, best, taken
):
    """Where it stood, carried over: from the nominal model on, the effect may not come among those tried.
    The contact is taken where it leaves clearly less, or does without an effect what the best did."""
    alone = 3.0
    *found, (known,) = on_the_other(paper, monkeypatch, alone, without, best)
    assert found == [taken, best if taken else alone]
    (carried,), model = known, paper.model
    assert carried.keys == (HUM,) and carried.refit.misfit == alone
    assert carried.refit.point.coordinates[model.index("A")] == 0.7
    assert model.index("mains_hum.sine")[0] in carried.refit.free


@pytest.mark.parametrize(("without", "taken"), [(1.1, False), (1.02, True)])
def test_where_an_effect_suffices_another_contact_must_do_without_it(paper, monkeypatch, without, taken):
    """Or nothing is surveyed there."""
    alone, best = 1.05, 1.01
    assert passes_for_noise(alone)
    *found, known = on_the_other(paper, monkeypatch, alone, without, best)
    assert found == [taken, best if taken else alone] and len(known) == taken
