"""When a contact takes the place of an effect that changes it, beside another effect."""

from __future__ import annotations

import dataclasses
import types
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis import other_contact
from fitting.diagnosis.bench import Point
from fitting.diagnosis.contest import Explanation
from fitting.diagnosis.other_contact import in_place_of_one_of_two
from fitting.diagnosis.refit import Refit
from fitting.diagnosis.screen import Promise
from fitting.diagnosis.shrink import Split
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
