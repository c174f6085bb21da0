"""What is seen only in runs that took no part."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis import diagnose as whole
from fitting.diagnosis import inquiry as inquiries
from fitting.diagnosis.accounts import Account
from fitting.diagnosis.diagnose import diagnose
from fitting.diagnosis.findings import Yardstick
from fitting.diagnosis.how_far.shrink import Split
from fitting.diagnosis.inquiry import Inquiry, _fits
from fitting.diagnosis.judging.judgement import Judgement
from fitting.diagnosis.settings import DiagnosisSettings
from fitting.diagnosis.unlisted.constancy import Trend
from fitting.diagnosis.unlisted.unrest import Unrest
from fitting.diagnosis.which.attribute import Attribution
from fitting.progress import Silent
from jaxstick.effect import AbstractEffect
from jaxstick.effects.mains_hum import MainsHum
from jaxstick.parts.drive import SineDrive
from jaxstick.record import DataSet
from tests.fitting.diagnosis.how_far.test_shrink import CLOSED
from tests.fitting.reference_data import WRONG, dataset, noisy, own_run

HUMS = "run-2.csv"
"""The one of four runs that is held out where nobody names any."""


def records() -> DataSet:
    """Four noisy runs, the force of one of which hums by three times its noise."""
    random = np.random.default_rng(4)
    runs = []
    for n, frequency in enumerate((0.8, 1.5, 2.6, 3.8)):
        file = f"run-{n}.csv"
        effects: dict[str, AbstractEffect] = {}
        if file == HUMS:
            effects["hum"] = MainsHum(cosine=0.08, sine=0.05, frequency=50.0)
        drive = SineDrive(frequency, 10.325e-3)
        runs.append(noisy(own_run(drive, effects=effects, samples=700, file=file), random))
    return dataset(*runs, assumed=WRONG)


def test_what_only_a_run_shows_that_was_held_out_is_named_with_another_held_out():
    found = diagnose(records(), DiagnosisSettings(workers=2))
    assert (found.verdict, found.named) == ("effect", ("mains_hum",))
    assert found.closure.held_out and HUMS not in found.closure.held_out


def test_a_gap_in_runs_that_are_to_be_held_out_is_said_to_be_there():
    """They stay so, nothing is named, and it is not called none."""
    found = diagnose(records(), DiagnosisSettings(hold_out=(HUMS,), workers=2))
    assert (found.verdict, found.named, found.closure.held_out) == ("unlisted", (), (HUMS,))
    assert found.closure.before > 1.5
    assert "something acts there that the others do not show" in found.notes[0] and HUMS in found.notes[0]


@pytest.mark.parametrize(
    ("verdict", "before", "scatters", "significance", "gapes"),
    [
        ("none", 1.2, False, 4.0, True),
        ("none", 1.05, False, 4.0, False),
        ("none", 1.2, True, 4.0, False),
        ("effect", 1.2, False, 4.0, False),
        ("none", 1.2, False, 1.8, False),
    ],
)
def test_a_gap_only_there_is_none_where_something_was_found_or_friction_scatters_or_few_segments_show_it(
    verdict, before, scatters, significance, gapes
):
    blank: Any = None
    found: Any = SimpleNamespace(judgement=SimpleNamespace(verdict=verdict))
    bench: Any = SimpleNamespace(scatters=scatters)
    shrunk = dataclasses.replace(CLOSED, before=before, floor=1.0, significance=significance)
    inquiry = Inquiry(blank, bench, blank, found, None, shrunk)
    assert inquiry.gapes_only_there is gapes
    said = inquiry.qualified().doubts
    assert len(said) == (significance < 2)
    assert all("so few of their segments" in doubt for doubt in said)


def inquiry(
    *keys: str, misfit: float = 1.02, after: float = 1.0, scatters: bool = False, same: tuple[str, ...] = ()
) -> Inquiry:
    """One that names these effects, with what they leave where they were fitted and where not; `same`: what
    they are not told from."""
    blank: Any = None
    named: Any = SimpleNamespace(keys=keys, refit=SimpleNamespace(misfit=misfit)) if keys else None
    found: Any = SimpleNamespace(floor=1.0, judgement=SimpleNamespace(named=(*keys, *same), verdict="effect"))
    bench: Any = SimpleNamespace(scatters=scatters)
    shrunk = dataclasses.replace(CLOSED, after=after, floor=1.0)
    return Inquiry(blank, bench, blank, found, named, shrunk)


def test_one_effect_lacks_something_where_only_runs_show_it_that_took_no_part():
    assert inquiry("cubic_stiffness", after=1.3).lacks_only_there
    assert not inquiry("cubic_stiffness", after=1.1).lacks_only_there
    assert not inquiry("cubic_stiffness", after=1.3, misfit=1.3).lacks_only_there
    assert not inquiry("cubic_stiffness", after=1.3, scatters=True).lacks_only_there
    assert not inquiry("cubic_stiffness", "end_stop", after=1.3).lacks_only_there
    assert not inquiry(after=1.3).lacks_only_there


def test_two_effects_say_more_than_one_of_them_that_lacks_the_other():
    one = inquiry("cubic_stiffness", after=1.3)
    assert inquiry("end_stop", "cubic_stiffness").says_more_than(one)
    assert not inquiry("end_stop", "cubic_stiffness", after=1.3).says_more_than(one)
    assert not inquiry("end_stop", "force_gain").says_more_than(one)
    assert not inquiry("cubic_stiffness").says_more_than(one)
    assert not inquiry().says_more_than(one)
    assert one.says_more_than(inquiry()) and not inquiry().says_more_than(inquiry())
    alias = inquiry("displacement_gain", after=1.3, same=("stiffness_error",))
    assert inquiry("stiffness_error", "end_stop").says_more_than(alias)


@pytest.mark.parametrize("keys", [(), ("stiffness_error",)])
def test_what_changes_along_the_runs_is_neither_nothing_nor_what_is_named(keys):
    """Nothing is closed then."""
    one = inquiry(*keys)
    one.found.astray, one.found.refuted = lambda: "astray", lambda: "refuted"  # pyright: ignore
    trend = Trend("stiffness_error", "stiffness_error (spring of another stiffness)", 400.0, 30.0, True)
    found = dataclasses.replace(one, anomalies=(Unrest(0.1),)).disproved(trend)
    assert found.found == ("refuted" if keys else "astray") and found.anomalies == (trend, Unrest(0.1))
    assert found.named is None and (not keys or found.shrunk.closed == 0.0)
    assert one.disproved(None) is one


@pytest.mark.parametrize(
    ("first", "second", "taken", "wanted"),
    [
        (inquiry("a", after=1.3), inquiry("a", "b"), "second", 2),
        (inquiry("a", after=1.3), inquiry("c"), "first", 2),
        (inquiry("a"), inquiry("a", "b"), "first", 1),
    ],
)
def test_other_runs_are_held_out_where_something_else_acts(monkeypatch, first, second, taken, wanted):
    """And what they show is taken if it is the same and more."""
    asked = []

    def inquire(paper, held, seed, progress):
        asked.append(held)
        return first if len(asked) == 1 else second

    monkeypatch.setattr(whole, "inquire", inquire)
    monkeypatch.setattr(whole, "split", lambda *_, **wanted: Split(np.zeros(1), np.zeros(1), ("run-1.csv",)))
    paper: Any = SimpleNamespace(problem=None, ground=SimpleNamespace(bench=None))
    found = whole._inquired(paper, (), DiagnosisSettings(), Silent())
    assert found is (first if taken == "first" else second) and len(asked) == wanted
    asked.clear()
    assert whole._inquired(paper, ("run-1.csv",), DiagnosisSettings(), Silent()) is first


@pytest.mark.parametrize(
    ("verdict", "named", "there", "seen", "after"),
    [
        ("none", (), ("bursts",), ("bursts",), "unlisted"),
        ("none", (), ("unrest",), ("unrest",), "unlisted"),
        ("none", (), ("bad_samples",), ("bad_samples",), "unlisted"),
        ("none", (), ("held_samples",), ("held_samples",), "unlisted"),
        ("none", (), ("jumps",), ("jumps",), "unlisted"),
        ("none", (), ("own_beat",), ("own_beat",), "unlisted"),
        ("none", (), (), (), "none"),
        ("unlisted", (), ("bad_samples", "bursts", "unrest"), ("bad_samples", "bursts"), "unlisted"),
        ("effect", ("a",), ("bad_samples", "bursts", "unrest"), (), "effect"),
    ],
)
def test_what_no_effect_does_is_looked_for_where_nothing_is_named(
    monkeypatch, verdict, named, there, seen, after
):
    for finder in ("bad_samples", "bursts", "held_samples", "jumps", "own_beat", "unrest"):
        monkeypatch.setattr(inquiries, finder, lambda *_, it=finder: it if it in there else None)
    monkeypatch.setattr(inquiries, "predicted", lambda *_: None)
    anything: Any = SimpleNamespace(
        model=None,
        ground=SimpleNamespace(scatter=None, bench=None, point=None),
        problem=SimpleNamespace(period=1.0),
    )

    def judged(verdict: str) -> Any:
        judgement = SimpleNamespace(verdict=verdict, named=named)
        return SimpleNamespace(judgement=judgement, nominal=None, astray=lambda: judged("unlisted"))

    found, anomalies = inquiries._off_the_shelf(anything, anything, judged(verdict))
    assert found.judgement.verdict == after
    assert anomalies == seen


@pytest.mark.parametrize(
    ("keys", "no_gap", "share", "restless", "stays"),
    [
        (("stribeck_shape",), True, (0.0, 0.32), True, False),
        (("stribeck_shape",), True, (0.0, 0.32), False, True),
        (("stribeck_shape",), True, (0.6, 0.9), True, True),
        (("stribeck_shape",), False, (0.0, 0.32), True, True),
        ((), True, (0.0, 0.0), True, True),
    ],
    ids=["scatters", "wanders", "closes a gap", "leaves less", "nothing named"],
)
def test_what_closes_no_gap_is_not_the_cause_where_friction_scatters_and_does_not_wander(
    monkeypatch, keys, no_gap, share, restless, stays
):
    """As under a pulsating spring: friction that happens to be steadier with a Stribeck curve between
    segments, while within them it scatters by thirty times as much. It is judged by what is named."""
    asked: list[Any] = []
    monkeypatch.setattr(inquiries.Scatter, "of", lambda *words: asked.append(words))
    said = Unrest(0.23) if restless else None
    monkeypatch.setattr(inquiries, "unrest", lambda problem, model, fit, scatter: asked.append(fit) or said)
    one = inquiry(*keys)
    one.found.shows_no_gap, one.found.refuted = no_gap, lambda: "refuted"  # pyright: ignore
    if one.named is not None:
        one.named.refit.point = "point"  # pyright: ignore
    chosen: Any = SimpleNamespace(model="model", problem=SimpleNamespace(period=0.2))
    shrunk = dataclasses.replace(CLOSED, before=1.2, floor=1.0, interval=share)
    one = dataclasses.replace(one, chosen=chosen, shrunk=shrunk)
    plain: Any = "plain"
    paper: Any = "paper"
    monkeypatch.setattr(inquiries, "_off_the_shelf", lambda *words: (words, ("a beat",)))
    found = inquiries._unless_restless(paper, one, plain)
    assert (found is one) is stays
    if not stays:
        assert (found.found, found.named, found.anomalies) == ("refuted", None, ("a beat", Unrest(0.23)))
        assert one.named is not None and asked == [("model", "plain", "point", 0.2), one.named.refit]


def test_what_is_named_is_compared_with_what_has_no_more_effects_and_none_of_its_own(monkeypatch):
    """Two effects that mimic one together are nothing to compare that one with."""
    monkeypatch.setattr(inquiries, "told_apart", lambda *_: True)
    explained = [
        SimpleNamespace(keys=keys, refit="+".join(keys))
        for keys in (("a",), ("a", "c"), ("c", "d"), ("b", "c"), ("c",), ("d",), ("b",))
    ]
    for taken, named, wrong, placebo in (
        (0, ("a",), "c", "b"),
        (0, ("a", "b"), "c", "d"),
        (1, ("a", "c"), "d", "b"),
        (3, ("b", "c"), "a", "d"),
    ):
        judgement = SimpleNamespace(named=named, steadier={})
        found: Any = SimpleNamespace(nominal="none", explanations=explained, judgement=judgement)
        one: Any = explained[taken]
        fits = {"nominal": "none", "named": one.refit, "wrong": wrong, "placebo": placebo}
        assert _fits(found, one) == fits
    assert _fits(found, None) == {"nominal": "none", "named": "none"}


@pytest.mark.parametrize(("apart", "wrong"), [("bcd", "b"), ("cd", "c"), ("d", "d"), ("", None)])
def test_what_is_named_is_compared_with_the_best_that_the_records_tell_from_it(monkeypatch, apart, wrong):
    """What holds the right effect within it leaves as little, and is of its class: the worst is no placebo
    the less."""
    one, *_ = explained = [SimpleNamespace(keys=(key,), refit=key) for key in "abcd"]
    judgement = SimpleNamespace(named=("a",), steadier={})
    found: Any = SimpleNamespace(nominal="none", explanations=explained, judgement=judgement)
    named: Any = one
    monkeypatch.setattr(inquiries, "told_apart", lambda first, other: first is one and other.refit in apart)
    fits = _fits(found, named)
    assert fits.get("wrong") == wrong
    assert fits["placebo"] == "d"


@pytest.mark.parametrize(
    ("named", "rival"), [(("a",), ("a", "c")), (("a", "c"), ("a",)), (("b",), None), (("b", "d"), ("d",))]
)
def test_a_rival_shares_an_effect_with_what_is_named_and_is_credited_with_steadier_friction(
    monkeypatch, named, rival
):
    monkeypatch.setattr(inquiries, "told_apart", lambda *_: True)
    likely = {"a": 0.3, "a+c": 0.2, "a+b": 0.25, "d": 0.05, "b": 0.1, "b+d": 0.1}
    explained = [SimpleNamespace(keys=tuple(name.split("+")), refit=name) for name in likely]
    steadier = {("a",): 2.0, ("a", "c"): 3.0, ("a", "b"): 0.0, ("d",): 1.0}
    judgement = SimpleNamespace(named=named, steadier=steadier, explanations=likely)
    found: Any = SimpleNamespace(nominal="none", explanations=explained, judgement=judgement)
    one: Any = next(e for e in explained if e.keys == named)
    assert _fits(found, one, inquiries._rival(found, one)).get("rival") == (
        None if rival is None else "+".join(rival)
    )


def test_the_rival_is_measured_where_what_is_named_is(monkeypatch):
    """Once two runs of six have said by how much steadier friction is with either; of what a second effect
    adds to that the share counts that did where it was fitted."""
    asked: list[Any] = []
    monkeypatch.setattr(inquiries, "weighed_again", lambda *words: asked.append(words) or judgement)
    nothing: Any = None
    one, both = Account(("a",), 1.3, 1, steadier=8.0), Account(("a", "c"), 1.1, 2, steadier=16.0)
    judgement: Any = SimpleNamespace(named=(), steadier={("a",): 8.0, ("a", "c"): 10.0})
    found = Attribution(nothing, (), nothing, judgement, Yardstick(9.0, 1.0, 1e4, 3.0, accounts=(one, both)))
    named, rival = (SimpleNamespace(keys=keys) for keys in (("a",), ("a", "c")))
    for closed, steadier in ((0.9, (0.0, 4.0)), (0.0, (-3.0, 4.0))):
        interval = (closed, closed)
        shrunk = dataclasses.replace(CLOSED, before=1.3, interval=interval, steadier=-3.0, rival=4.0)
        inquiries.confirmed(found, named, shrunk, rival)  # pyright: ignore[reportArgumentType]
        assert asked.pop()[1:] == (("a",), steadier[0], {("a", "c"): 10.0 / 16.0 * steadier[1]})


@pytest.mark.parametrize(
    ("left", "credit", "counts"), [(1.3, 8.0, 3.0), (1.2, 8.0, 4.0), (1.3, 8.5, 4.0), (1.31, 7.0, 3.0)]
)
def test_what_adds_nothing_where_it_was_fitted_is_not_called_for_elsewhere(
    monkeypatch, left: float, credit: float, counts: float
):
    """A second effect that mends the shape of a drift, on two other runs, by more than it does in four."""
    asked: list[Any] = []
    monkeypatch.setattr(inquiries, "weighed_again", lambda *words: asked.append(words) or judgement)
    nothing: Any = None
    one, both = Account(("a",), 1.3, 1, steadier=8.0), Account(("a", "c"), left, 2, steadier=credit)
    judgement: Any = SimpleNamespace(named=(), steadier={("a",): 8.0, ("a", "c"): credit})
    found = Attribution(nothing, (), nothing, judgement, Yardstick(9.0, 1.0, 1e4, 3.0, accounts=(one, both)))
    named, rival = (SimpleNamespace(keys=keys) for keys in (("a",), ("a", "c")))
    shrunk = dataclasses.replace(CLOSED, before=1.3, steadier=3.0, rival=4.0)
    inquiries.confirmed(found, named, shrunk, rival)  # pyright: ignore[reportArgumentType]
    assert asked.pop()[1:] == (("a",), 3.0, {("a", "c"): counts})


@pytest.mark.parametrize(
    ("after", "inflation", "stays"), [(1.054, 50.0, True), (1.054, 3.0, False), (1.07, 50.0, False)]
)
def test_what_a_gap_grows_by_where_nothing_acts_may_be_chance(after: float, inflation: float, stays: bool):
    """A table that rings in one run alone, which was fitted: five parameters, told by 10000 residuals of
    friction that scatters, that leave 1.0127 times as much chi-square where it does not ring."""
    keys = ("rings",)
    names = "rings", "none", "unlisted"
    explanations: dict[str, float] = dict(zip(names, (0.97, 0.01, 0.02), strict=True))
    judgement = Judgement(explanations, explanations, "effect", keys, {keys: 0.0}, {})
    against = Yardstick(2.4, 1.0, 1e4, inflation, accounts=(Account(keys, 1.0, 5),))
    nominal, refit = (SimpleNamespace(cost=np.full(5, left), misfit=left) for left in (2.4, 1.0))
    found: Any = Attribution(nominal, (), None, judgement, against)  # pyright: ignore[reportArgumentType]
    named: Any = SimpleNamespace(keys=keys, refit=refit)
    shrunk = dataclasses.replace(
        CLOSED, before=1.048, after=after, gain=-0.01, closed=0.0, interval=(-1.0, 0.1)
    )
    assert inquiries.confirmed(found, named, shrunk).named == (keys if stays else ())


@pytest.mark.parametrize(
    ("left", "gained", "likely", "taken"),
    [
        (0.9, 0.3, 0.2, ("stop",)),
        (0.9, 0.1, 0.2, None),
        (1.1, 0.3, 0.2, None),
        (0.9, 0.3, 0.01, None),
    ],
    ids=["carries over", "does not", "leaves more", "hardly likely"],
)
def test_what_carries_over_succeeds_what_other_runs_speak_against(
    monkeypatch, left: float, gained: float, likely: float, taken: tuple[str, ...] | None
):
    """An end stop that acts in a few runs, for which a cubic spring stood: it leaves less where it was
    fitted, and gains where it was not what it gained there."""
    rest = {"none": 0.05, "unlisted": 0.15, "both+stop": 0.0}
    names = "cubic", "stop", "both", "none", "unlisted"
    explanations = {"cubic": 0.8 - likely, "stop": likely, **rest}
    judgement = Judgement(
        explanations, dict.fromkeys(names, 0.0), "effect", ("cubic",), {("cubic",): 0.0, ("stop",): 0.0}, {}
    )
    fits = {"none": 10.0, "cubic": 1.0, "stop": left, "both+stop": 0.5}
    nominal, *refits = (SimpleNamespace(cost=np.full(5, fit), misfit=fit) for fit in fits.values())
    refits[1].cost = np.full(5, 10 * np.exp(-0.4))
    explained = [
        SimpleNamespace(keys=tuple(name.split("+")), refit=refit)
        for name, refit in zip(("cubic", "stop", "both+stop"), refits, strict=True)
    ]
    found: Any = Attribution(nominal, tuple(explained), None, judgement, None)  # pyright: ignore[reportArgumentType]
    shrunk = dataclasses.replace(CLOSED, gain=gained)
    monkeypatch.setattr(inquiries, "_shrunk", lambda *_: shrunk)
    monkeypatch.setattr(inquiries, "confirmed", lambda found, *_: found.judgement)
    judged = inquiries._succeeded(None, None, found, explained[0], 0)  # pyright: ignore[reportArgumentType]
    assert (None if judged is None else judged.named) == taken
