"""The verdict in words."""

from __future__ import annotations

import dataclasses
import types
from typing import Any

import pytest

from fitting.diagnosis.judging.judgement import Judgement
from fitting.diagnosis.lanes.model import Shelf
from fitting.diagnosis.noise.scatter import Scatter
from fitting.diagnosis.unlisted.bursts import Bursts
from fitting.diagnosis.unlisted.unrest import Unrest
from fitting.diagnosis.where.clue import Clue
from fitting.diagnosis.words import advice, in_turn, refutation, remainders, scattering, sentence, stiller
from jaxstick.catalogue import catalogue

ONE, OTHER, ALIAS = "constant_force", "base_delay", "base_relative_damping"


@pytest.mark.parametrize("likely", [0.48, 0.3])
def test_what_may_act_in_the_place_of_one_of_two_is_said(diagnosis, likely):
    """And not what is far less likely there."""
    model = types.SimpleNamespace(shelf=Shelf(catalogue(), {}, {}, {}))
    explanations = {f"{ONE}+{OTHER}": 0.5, f"{ALIAS}+{ONE}": likely, ALIAS: 0.05, "none": 0.0}
    named = (ONE, OTHER, ALIAS) if likely > 0.4 else (ONE, OTHER)
    judgement = Judgement(explanations, {}, "several", named, {}, {})
    said = sentence(model, judgement, diagnosis.closure, diagnosis.where)  # pyright: ignore[reportArgumentType]
    assert said.startswith(f"{ONE} (") and f" and {OTHER} (" in said and "act together" in said
    assert (f"in the place of {OTHER} these records would have {ALIAS} (" in said) == (likely > 0.4)


def test_what_no_record_tells_from_one_of_two_is_said_once(diagnosis):
    model: Any = types.SimpleNamespace(shelf=Shelf(catalogue(), {}, {}, {}))
    explanations = {f"{ONE}+{OTHER}": 0.5, f"{ALIAS}+{ONE}": 0.48, "none": 0.0}
    classes = {(OTHER, ONE): (ALIAS,)}
    judgement = Judgement(explanations, {}, "several", (ONE, OTHER, ALIAS), {}, classes)
    said = sentence(model, judgement, diagnosis.closure, diagnosis.where)
    assert said.endswith(f"; no record tells {OTHER} from {ALIAS}.") and "in the place of" not in said


def test_wandering_that_takes_over_an_effect_is_said():
    (said,) = stiller(("friction_drift",), 5.0, 2.0)
    assert said.startswith(
        "Friction wanders from segment to segment by 2 % (standard deviation) with friction_"
    )
    assert "friction_drift, by 5 % without" in said
    assert stiller(("friction_drift",), 5.0, 4.0) == stiller(("friction_drift",), 0.3, 0.1) == []


def test_the_order_of_links_is_said_from_the_contact_to_the_record():
    (said,) = in_turn(["force_clipping", "mains_hum"])
    assert "passes force_clipping first and then mains_hum" in said
    assert in_turn([]) == in_turn(["mains_hum"]) == []


@pytest.mark.parametrize(("wander", "condition"), [(0.2, ""), (5.1, ", if friction may wander by 5.1 %")])
def test_none_is_said_with_what_friction_has_to_do_for_it(diagnosis, wander, condition):
    model: Any = None
    judgement = Judgement({"none": 1.0}, {}, "none", (), {}, {})
    said = sentence(model, judgement, diagnosis.closure, diagnosis.where, wander)
    assert said.startswith("The records agree with the simulator within their noise" + condition)
    assert ("wander" in said) == bool(condition)


def test_what_no_effect_does_is_the_verdict_where_nothing_else_is(diagnosis):
    """The plainest of it."""
    model: Any = None
    judgement = Judgement({"unlisted": 1.0}, {}, "unlisted", (), {}, {})
    rises = Bursts(5, 6, 0.023, 0.12)
    said = sentence(model, judgement, diagnosis.closure, diagnosis.where, 0.0, (rises, Unrest(0.012)))
    assert said == f"No effect on the shelf explains the records: {rises.clause}."
    assert "times the noise" in sentence(model, judgement, diagnosis.closure, diagnosis.where, 0.012)


def test_what_the_gap_follows_is_said_where_no_effect_explains_it(diagnosis):
    """In the verdict, unless something plainer is, and as what to look for next."""
    model: Any = None
    judgement = Judgement({"unlisted": 1.0}, {}, "unlisted", (), {}, {})
    clue, known = Clue("mechanics", "beat", 0.98, 46.78), (diagnosis.closure, diagnosis.where, 0.0)
    said = sentence(model, judgement, *known, clue=clue)
    assert said.endswith(f" times the noise: {clue.clause}.") and "it lies" not in said
    assert sentence(model, judgement, *known, (Unrest(0.1),), clue).endswith(f"{Unrest(0.1).clause}.")
    found: Any = types.SimpleNamespace(judgement=judgement)
    problem, bench = (types.SimpleNamespace() for _ in range(2))
    assert advice(problem, model, found, bench, None, clue) == clue.look  # pyright: ignore[reportArgumentType]
    assert "at 46.78 Hz: gears" in clue.look
    rises = Bursts(5, 6, 0.023, 0.12)
    assert advice(problem, model, found, bench, None, rises) == rises.look  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    ("closed", "before", "steadier", "said"),
    [
        (0.98, 4.0, 9.0, "it closes 98 % of the reducible gap on runs that took no part."),
        (-0.07, 1.5, 9.0, "it closes nothing of the gap on runs that took no part, since friction that may"),
        (-0.07, 1.5, 0.0, "it closes nothing of the gap on runs that took no part."),
        (0.0, 1.01, 9.0, "on runs that took no part there is no gap to be closed, since friction that may"),
        (0.0, 1.01, 0.0, "on runs that took no part there is no gap to be closed."),
    ],
)
def test_what_closes_nothing_is_said_to_and_why(diagnosis, closed, before, steadier, said):
    key = "friction_drift"
    judgement = Judgement({key: 1.0}, {key: 1.0}, "effect", (key,), {(key,): steadier}, {})
    shrunk = dataclasses.replace(diagnosis.closure, closed=closed, steadier=1.0, by_segments=False)
    shrunk = dataclasses.replace(shrunk, before=before, floor=1.0)
    model: Any = types.SimpleNamespace(shelf=Shelf(catalogue(), {}, {}, {}))
    assert said in sentence(model, judgement, shrunk, diagnosis.where)


@pytest.mark.parametrize(
    ("after", "steadier", "said"),
    [
        (3.9, -2.0, "that may be chance"),
        (3.9, 1.0, "it is not the cause"),
        (5.0, -2.0, "it is not the cause"),
    ],
)
def test_what_other_runs_do_not_confirm_is_said_why(diagnosis, after, steadier, said):
    shrunk = dataclasses.replace(diagnosis.closure, before=3.91, after=after, steadier=steadier)
    assert said in refutation(("friction_drift",), shrunk)


@pytest.mark.parametrize(
    ("best", "after", "said"),
    [
        (1.02, 1.1, None),
        (1.02, 1.3, "on runs that took no part 1.3 times what no model can get below"),
        (1.3, 1.5, None),
        (2.5, 1.3, "a misfit of 2.5 times what no model can get below"),
    ],
)
def test_what_is_left_beside_what_is_named_is_said(diagnosis, best, after, said):
    named: Any = types.SimpleNamespace(refit=types.SimpleNamespace(misfit=best))
    found: Any = types.SimpleNamespace(explanations=[named], floor=1.0)
    shrunk = dataclasses.replace(diagnosis.closure, after=after, floor=1.0, by_segments=False)
    notes = remainders(found, named, shrunk)
    assert (said is None and notes == []) or (said is not None and said in notes[0] and len(notes) == 1)
    assert remainders(found, None, shrunk) == []


def test_what_scatters_is_said_of_the_channels_that_there_are():
    scatter = Scatter({"stick": (9.0, 1.0), "slip": (4.0, 16.0)}, None, 0.2)
    (both,), (motion,) = scattering(scatter, silent=False), scattering(scatter, silent=True)
    assert "each scatters most, the displacement does by 3 and the friction force by 4 times" in both
    assert "it scatters most, the displacement does by 3 times" in motion and "friction" not in motion
    assert len(scattering(dataclasses.replace(scatter, left=scatter.variances), silent=False)) == 2
