"""What does not repeat itself is found anew where an explanation shows that it was overrated."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis import turns
from fitting.diagnosis.how_far.shrink import Split
from fitting.diagnosis.lanes.bench import Bench
from fitting.diagnosis.noise.ground import Ground
from fitting.diagnosis.noise.scatter import Scatter
from fitting.diagnosis.refits.refit import Refit
from fitting.diagnosis.which.contacts import Chosen
from fitting.diagnosis.which.explanation import Explanation
from fitting.diagnosis.which.screen import Promise, Screen
from fitting.diagnosis.which.survey import NOTABLE, Survey
from fitting.problem import pose
from fitting.progress import Silent
from fitting.settings import Settings
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import UNEVEN, WORKERS, from_the_truth, laid_out
from tests.fitting.reference_data import NOISE, TRUTH, dataset, noisy, own_run

NOBODY = np.zeros(0)
PROMISE = Promise(UNEVEN, NOBODY, 1.0, NOBODY, 1.0, NOBODY, NOBODY, NOBODY, NOBODY, NOBODY)
SCREEN = Screen((PROMISE,), (UNEVEN,), (PROMISE,), np.eye(1), ())


@dataclasses.dataclass
class Laid:
    """A run whose friction force scatters by eight times its noise, every fifth lane held out; the refit at
    the true constants, and a poor one whose lanes begin anywhere near where they should."""

    paper: Chosen
    plain: Bench
    held: Split
    right: Refit
    poor: Refit


@pytest.fixture(scope="module")
def laid() -> Laid:
    assert NOISE.friction is not None
    random = np.random.default_rng(6)
    run = noisy(own_run(SineDrive(0.9, 10.325e-3), samples=3000), random)
    assert run.friction is not None
    run = dataclasses.replace(run, friction=run.friction + 8 * NOISE.friction * random.standard_normal(3000))
    stated = dataset(run)
    model, bench = laid_out(stated)
    every = from_the_truth(model, bench, (), model.origin(TRUTH))
    lanes = np.arange(len(bench.lanes))
    held = Split(lanes[lanes % 5 > 0], lanes[lanes % 5 == 0], ())
    right = dataclasses.replace(every, point=every.point.take(held.fitted))
    astray = right.point.own.copy()
    astray[:, 0] += 1e-3 * random.standard_normal(len(astray))
    poor = dataclasses.replace(right, point=dataclasses.replace(right.point, own=astray))
    ground = Ground((), bench, every.point, np.zeros((0, 5)), bench)
    paper = Chosen(pose(stated, Settings(workers=WORKERS)), model, ground)
    return Laid(paper, bench.take(held.fitted), held, right, poor)


def surveyed(
    laid: Laid,
    monkeypatch: pytest.MonkeyPatch,
    *script: tuple[Refit, float, float],
    nominal: float = 70.0,
    floors: tuple[float, ...] = (1.0,),
    asked: list[Bench] | None = None,
    two: Explanation | None = None,
):
    """What is found where surveys come, one after the other, to these refits with these misfits above these
    floors; all of them are made, and no more, and each is told what the one before found. No other contact
    explains anything; `asked` takes the benches on which one was tried. The poor refit is the `nominal`
    model's, with that misfit; `floors`: under it, and under what the first survey found, where that is asked
    for; `two`: what keeps another time beside the best effect."""
    left, told = list(script), list(floors)
    known: list[tuple[Explanation, ...]] = []

    def beside(chosen: Chosen, bench: Bench, seen: Survey, *others: object) -> tuple[Chosen, Survey]:
        if asked is not None:
            asked.append(bench)
        return chosen, seen

    def scripted(*given: object) -> Survey:
        assert [each for each in given[5:] if each] == known[-1:]
        fit, misfit, floor = left.pop(0)
        fit = dataclasses.replace(fit, misfit=misfit)
        known.append((Explanation((UNEVEN,), PROMISE, fit),))
        return Survey(fit, SCREEN, known[-1], floor)

    def another(model: object, bench: Bench, best: Explanation, *others: object) -> Explanation | None:
        assert bench is laid.plain
        if two is not None:
            known[-1] = two, best
        return two

    def floor(model: object, bench: Bench, fits: Sequence[Refit]) -> float:
        assert bench is laid.plain
        return told.pop(0)

    poor = dataclasses.replace(laid.poor, misfit=nominal)
    monkeypatch.setattr(turns, "nominal_on", lambda *_: poor)
    monkeypatch.setattr(turns, "fitted_again", lambda *_: [Explanation((UNEVEN,), PROMISE, laid.right)])
    monkeypatch.setattr(turns, "in_another_time", another)
    monkeypatch.setattr(turns, "floor_of", floor)
    monkeypatch.setattr(turns, "survey", scripted)
    monkeypatch.setattr(turns, "beside_single_effects", beside)
    found = turns.surveyed(laid.paper, laid.plain, laid.right.point, laid.held, Silent())
    assert not left and not told
    return found


def test_records_that_repeat_themselves_are_surveyed_once(laid, monkeypatch):
    chosen, bench, seen = surveyed(laid, monkeypatch, (laid.right, 1.0, 1.0))
    assert bench is laid.plain and chosen is laid.paper and seen.least == 1.0


def test_what_scatters_is_weighed_before_the_first_survey(laid, monkeypatch):
    """By what does not repeat itself under the nominal model."""
    chosen, bench, _ = surveyed(laid, monkeypatch, (laid.right, 1.0, 1.0), floors=(65.0, 40.0))
    assert chosen.ground.scatter == Scatter.of(
        chosen.model, laid.plain, laid.poor.point, chosen.problem.period
    )
    assert bench.scatters and chosen.ground.bench.scatters


def test_what_hardly_scatters_beside_a_strong_effect_is_weighed_once_that_is_found(laid, monkeypatch):
    script = (laid.right, 70.0, 65.0), (laid.right, 1.0, 1.0)
    chosen, bench, _ = surveyed(laid, monkeypatch, *script, nominal=1000.0, floors=(65.0,))
    assert chosen.ground.scatter == Scatter.of(
        chosen.model, laid.plain, laid.right.point, chosen.problem.period
    )
    assert bench.scatters


def test_what_only_keeps_another_time_is_not_weighed_by(laid, monkeypatch):
    """Hum, say, which does not repeat itself with the excitation until it is in the model."""
    script = (laid.right, 0.1, 1.0), (laid.right, 1.0, 1.0)
    chosen, bench, seen = surveyed(laid, monkeypatch, *script, floors=(65.0, 1.0))
    assert chosen is laid.paper and bench is laid.plain and seen.least == 1.0


@pytest.mark.parametrize("floors", [(65.0, 40.0, 1.0), (1.0, 1.0)])
def test_what_keeps_another_time_beside_another_effect_is_no_scatter(laid, monkeypatch, floors):
    """Hum beside a force that is clipped, found before or after residuals are first weighed by scatter."""
    both = Explanation((UNEVEN, "mains_hum"), PROMISE, dataclasses.replace(laid.right, misfit=1.0))
    first = [(laid.right, 1.0, 1.0)] if len(floors) > 2 else []
    script = *first, (laid.right, 70.0, 65.0)
    chosen, bench, seen = surveyed(laid, monkeypatch, *script, floors=floors, two=both)
    assert chosen is laid.paper and bench is laid.plain and not seen.scatters
    assert [e.keys for e in seen.found] == [both.keys, (UNEVEN,)]


@pytest.mark.parametrize("floor", [1.0, 1.3])
def test_what_nothing_explains_once_weighed_is_sought_in_units_of_the_noise(laid, monkeypatch, floor):
    """A table that rings on from cycle to cycle, say; what scatters under that as well is scatter."""
    script = (laid.poor, 1.6, 1.0), (laid.right, 1.0, floor)
    chosen, bench, _ = surveyed(laid, monkeypatch, *script, floors=(65.0, 40.0))
    assert (chosen is laid.paper and bench is laid.plain) is (floor <= NOTABLE)
    assert bench.scatters is (floor > NOTABLE)


def test_what_was_overrated_is_found_anew_and_not_on_top(laid, monkeypatch):
    """From the residuals in units of the noise, on what is held out as well."""
    script = (laid.poor, 70.0, 65.0), (laid.right, 0.3, 1.0), (laid.right, 1.0, 1.0)
    chosen, bench, _ = surveyed(laid, monkeypatch, *script)
    overrated = Scatter.of(chosen.model, laid.plain, laid.poor.point, chosen.problem.period)
    scatter = Scatter.of(chosen.model, laid.plain, laid.right.point, chosen.problem.period)
    assert scatter.variances["slip"][1] == pytest.approx(1 + 8**2, rel=0.2)
    assert overrated.variances["slip"][0] > 10 * scatter.variances["slip"][0]
    assert chosen.ground.scatter == scatter
    wanted = scatter.evened(chosen.model, laid.plain, laid.right.point).lanes.weights()
    np.testing.assert_allclose(bench.lanes.weights(), wanted)
    np.testing.assert_allclose(chosen.ground.bench.take(laid.held.fitted).lanes.weights(), wanted)
    assert chosen.ground.bench.scatters and len(chosen.ground.bench.lanes) > len(bench.lanes)
    assert bench.lanes.substeps < laid.plain.lanes.substeps == chosen.ground.bench.lanes.substeps


@pytest.mark.parametrize(
    ("script", "tried"), [([(1.0, 1.0)], 0), ([(1.6, 1.0)], 1), ([(70.0, 65.0), (1.0, 1.0)], 1)]
)
def test_contacts_are_tried_where_something_is_left_and_where_friction_scatters(
    laid, monkeypatch, script, tried
):
    """For scatter hides what they leave."""
    asked: list[Bench] = []
    surveyed(laid, monkeypatch, *((laid.right, *each) for each in script), asked=asked)
    assert len(asked) == tried and all(bench.scatters == (len(script) > 1) for bench in asked)


def test_it_ends_where_nothing_helps(laid, monkeypatch):
    script = (laid.poor, 70.0, 65.0), *((laid.poor, 0.3, 1.0) for _ in range(turns.TURNS))
    assert surveyed(laid, monkeypatch, *script)[2].least == 0.3


@dataclasses.dataclass
class Judged:
    """What of an attribution counts here."""

    explanations: tuple[Explanation, ...]


def weighed_anew(laid: Laid, monkeypatch: pytest.MonkeyPatch, bench: Bench, *misfits: float):
    """What is found where the explanations leave these misfits, the first on a bench and the others on those
    that follow; all of them are asked for."""
    left = [
        Judged((Explanation((UNEVEN,), PROMISE, dataclasses.replace(laid.right, misfit=m)),)) for m in misfits
    ]

    def again(model: object, bench: Bench, found: Judged) -> Judged:
        assert bench.scatters and found is left[0]
        del left[0]
        return left[0]

    monkeypatch.setattr(turns, "on_another_bench", again)
    first: Any = left[0]
    found = turns.weighed_anew(laid.paper, laid.paper, bench, laid.plain, laid.held, first)
    assert len(left) == 1 and found[2] is left[0]
    return found


def test_what_two_effects_show_to_be_overrated_is_found_anew(laid, monkeypatch):
    """Under them, from the residuals in units of the noise."""
    chosen, period = laid.paper, laid.paper.problem.period
    wrong = Scatter.of(chosen.model, laid.plain, laid.poor.point, period)
    bench = wrong.evened(chosen.model, laid.plain, laid.poor.point)
    again, found, _ = weighed_anew(laid, monkeypatch, bench, 0.6, 0.9)
    scatter = Scatter.of(chosen.model, laid.plain, laid.right.point, period)
    wanted = scatter.evened(chosen.model, laid.plain, laid.right.point).lanes.weights()
    np.testing.assert_allclose(found.lanes.weights(), wanted)
    assert again.ground.scatter == scatter
    assert weighed_anew(laid, monkeypatch, bench, 0.9)[:2] == (chosen, bench)
    assert weighed_anew(laid, monkeypatch, laid.plain, 0.6)[:2] == (chosen, laid.plain)
    weighed_anew(laid, monkeypatch, bench, *[0.6] * (1 + turns.TURNS))


class Again:
    """What is found where residuals were weighed by what does not repeat itself under a wrong refit, and the
    best explanation, fitted in units of the noise, leaves such a floor there; weighed by what it leaves, it
    leaves such misfits, time after time."""

    def __init__(
        self, laid: Laid, monkeypatch: pytest.MonkeyPatch, wrong: Refit, floor: float, *misfits: float
    ) -> None:
        model, period = laid.paper.model, laid.paper.problem.period
        scatter = Scatter.of(model, laid.plain, wrong.point, period)
        self.before = scatter.evened(model, laid.plain, wrong.point)
        ground = dataclasses.replace(laid.paper.ground, scatter=scatter)
        self.chosen = dataclasses.replace(laid.paper, ground=ground)
        refits = [laid.poor, laid.poor, *(dataclasses.replace(laid.right, misfit=m) for m in misfits)]
        self.found, self.sought, *self.weighed = (
            Judged((Explanation((UNEVEN,), PROMISE, one),)) for one in refits
        )
        self.benches: list[Bench] = []
        self.paired: list[tuple[Bench, Judged]] = []

        def told(bench: Bench, found: Judged) -> Judged:
            self.benches.append(bench)
            return found

        def by_turns(_: object, bench: Bench, found: Judged) -> Judged:
            return told(bench, self.weighed[len(self.benches)])

        def paired(_: object, bench: Bench, found: Judged, progress: object) -> Judged:
            self.paired.append((bench, found))
            return found

        monkeypatch.setattr(turns, "with_pairs_anew", paired)
        monkeypatch.setattr(turns, "refit", lambda *_: [laid.right])
        monkeypatch.setattr(turns, "floor_of", lambda _, bench, fits: floor if bench is laid.plain else None)
        monkeypatch.setattr(turns, "on_another_bench", by_turns)
        monkeypatch.setattr(turns, "_sought_anew", lambda _, bench, *given: told(bench, self.sought))
        self.laid = laid
        self.again, self.bench, self.out = self.on(self.before)

    def on(self, bench: Bench) -> tuple[Chosen, Bench, Any]:
        found: Any = self.found
        laid = self.laid
        return turns.less_scattered(laid.paper, self.chosen, bench, laid.plain, laid.held, found, Silent())


def test_what_repeats_itself_under_the_best_explanation_is_sought_in_units_of_the_noise(laid, monkeypatch):
    made = Again(laid, monkeypatch, laid.poor, 1.0)
    assert made.out is made.sought and made.benches == [laid.plain] and made.bench is laid.plain
    assert made.again.ground.scatter is None and made.again.ground.bench is laid.paper.ground.bench


def test_what_scatters_less_under_the_best_explanation_is_weighed_anew(laid, monkeypatch):
    """And pairs are sought there, for what was weighed by hid what a second effect does."""
    made = Again(laid, monkeypatch, laid.poor, 60.0, 0.9)
    assert made.out is made.weighed[0] and made.benches == [made.bench] and made.bench is not made.before
    model, period = laid.paper.model, laid.paper.problem.period
    assert made.again.ground.scatter == Scatter.of(model, laid.plain, laid.right.point, period)
    assert made.paired == [(made.bench, made.weighed[0])]


def test_what_is_overrated_where_the_best_was_fitted_in_units_of_the_noise_is_weighed_once_more(
    laid, monkeypatch
):
    """Fitted to residuals that are weighed so it leaves less than it did there."""
    made = Again(laid, monkeypatch, laid.poor, 60.0, 0.6, 0.9)
    assert made.out is made.weighed[1] and len(made.benches) == 2 and made.bench is made.benches[1]


def test_what_scatters_as_it_was_taken_to_stays(laid, monkeypatch):
    made = Again(laid, monkeypatch, laid.right, 60.0)
    assert (made.again, made.bench, made.out) == (made.chosen, made.before, made.found)
    assert made.on(laid.plain) == (made.chosen, laid.plain, made.found) and not made.benches


def test_what_is_sought_anew_begins_with_what_is_known(laid, monkeypatch):
    """Of each single effect the better fit counts, pairs are handed on, and the lower floor is the floor."""

    def explained(misfit: float, *keys: str) -> Explanation:
        return Explanation(keys, PROMISE, dataclasses.replace(laid.right, misfit=misfit))

    pair, *singles = explained(1.0, "a", "b"), explained(2.0, "a"), explained(3.0, "c")
    fits = [e.refit for e in (pair, *singles)]
    seen = Survey(laid.poor, SCREEN, (explained(2.5, "c"), explained(4.0, "a")), 1.3)
    found: Any = SimpleNamespace(leading=(pair, *singles), nominal=laid.poor)
    monkeypatch.setattr(turns, "fitted_again", lambda _, bench, explanations: list(explanations))
    monkeypatch.setattr(turns, "nominal_on", lambda *_: laid.poor)
    monkeypatch.setattr(turns, "survey", lambda *_: seen)
    monkeypatch.setattr(turns, "floor_of", lambda _, bench, given: 1.1 if given == [laid.poor, *fits] else 0)
    monkeypatch.setattr(turns, "attribute", lambda model, bench, *given: given)
    anew: Any = turns._sought_anew(laid.paper.model, laid.plain, NOBODY, found, Silent())
    survey, _, known = anew
    assert [(e.keys, e.refit.misfit) for e in survey.found] == [(("a",), 2.0), (("c",), 2.5)]
    assert survey.floor == 1.1 and survey.nominal is laid.poor and known == [pair]
