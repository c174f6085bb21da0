"""The run that is proposed where two explanations are left open."""

from __future__ import annotations

import dataclasses
import functools
import types
from typing import Any, NamedTuple

import numpy as np
import pytest

from fitting.diagnosis.findings import MOST_TIMES, TELLING, Plan, Proposal
from fitting.diagnosis.judging.judgement import Judgement
from fitting.diagnosis.lanes.bench import Bench, Point
from fitting.diagnosis.lanes.wander import LEAST, OWN, START
from fitting.diagnosis.next_run import left, rivals
from fitting.diagnosis.noise.ground import Ground
from fitting.diagnosis.planned import AMPLITUDES, BEYOND, CYCLES, plans, recorded
from fitting.diagnosis.refits.refit import Refit, refit
from fitting.diagnosis.refits.release import all_settled
from fitting.diagnosis.which.contacts import Chosen
from fitting.diagnosis.words import proposed
from fitting.problem import Problem, pose
from fitting.settings import Settings
from jaxstick.effects.asymmetric_friction import AsymmetricFriction
from jaxstick.parts.drive import SineDrive
from jaxstick.record import DataSet, Run
from tests.fitting.diagnosis.grounded import UNEVEN, WORKERS, laid_out, noisy_runs
from tests.fitting.reference_data import TRUTH, dataset, own_run

RIVAL = "friction_drift"
DRY = 0.003
AMPLITUDE, SLOW, FAST = 10.325e-3, 0.9, 2.1
PLANS = [Plan(0.9, AMPLITUDE, by_force=False), Plan(FAST, 0.5 * AMPLITUDE, by_force=False)]


class Seen(NamedTuple):
    """A data set of two runs whose dry friction differs between the directions, its lanes, and two effects
    fitted to them: the one that acts, and another."""

    chosen: Chosen
    bench: Bench
    true: Refit
    rival: Refit


@functools.cache
def seen() -> Seen:
    acting = {UNEVEN: AsymmetricFriction(DRY, 0.0)}
    stated = dataset(*noisy_runs(dict.fromkeys((SLOW, FAST), acting), 7))
    model, bench = laid_out(stated)
    keys, begin = model.sharing.together((UNEVEN, RIVAL)), model.origin(TRUTH)
    point = Point(
        keys,
        begin,
        model.alike(bench.runs),
        np.asarray(bench.lanes.start),
        np.full(OWN - START, LEAST),
    )
    constants = model.index(*model.constants)
    frees = [np.concatenate([constants, model.of(key)]) for key in (UNEVEN, RIVAL)]
    true, rival = refit(model, bench, [point, point], frees, wander=False)
    chosen = Chosen(
        pose(stated, Settings(workers=WORKERS)), model, Ground((), bench, point, begin[None], bench)
    )
    return Seen(chosen, bench, true, rival)


def of(*runs: Run) -> Problem:
    return pose(dataset(*runs), Settings(workers=WORKERS))


def test_runs_are_planned_around_the_recorded_ones():
    slow, fast = (own_run(SineDrive(f, a), samples=1500) for f, a in ((SLOW, 8e-3), (FAST, 2e-3)))
    found = plans(of(slow, fast))
    frequencies = sorted({plan.frequency for plan in found})
    assert frequencies[-1] == pytest.approx(FAST * BEYOND, rel=1e-6)
    assert frequencies[0] == pytest.approx(max(SLOW / BEYOND, CYCLES / 3.0), rel=1e-3)
    assert len(found) == len(AMPLITUDES) * len(frequencies) and not any(plan.by_force for plan in found)
    for plan in found[1 :: len(AMPLITUDES)]:
        assert 2e-3 * (1 - 1e-6) <= plan.amplitude <= 8e-3 * (1 + 1e-6)
    assert max(plan.amplitude for plan in found) == pytest.approx(16e-3, rel=1e-6)


def test_where_a_force_drives_the_rig_so_it_does_in_what_is_planned():
    found = plans(of(own_run(SineDrive(1.0, force_amplitude=9.0), samples=1500)))
    assert found and all(plan.by_force for plan in found)
    assert {round(plan.amplitude, 6) for plan in found} == {4.5, 9.0, 18.0}


def test_nothing_is_planned_where_no_sine_drives_the_rig():
    run = own_run(SineDrive(1.0, AMPLITUDE), samples=600)
    base = AMPLITUDE * np.cumsum(np.random.default_rng(0).standard_normal(600)) / 30
    assert plans(of(dataclasses.replace(run, base=base))) == []


def test_what_would_be_recorded_is_what_the_fit_says():
    """The plan of a recorded run shows, once the motion has settled, what that run has without noise."""
    chosen, _, true, _ = seen()
    (signal,) = recorded(chosen.problem, chosen.model, true, PLANS[:1])
    exact = own_run(SineDrive(SLOW, AMPLITUDE), effects={UNEVEN: AsymmetricFriction(DRY, 0.0)}, samples=9000)
    assert signal.run.friction is not None and exact.friction is not None
    one = np.ptp(signal.run.displacement), np.ptp(signal.run.friction)
    other = np.ptp(exact.displacement[-1000:]), np.ptp(exact.friction[-1000:])
    np.testing.assert_allclose(one, other, rtol=0.02)
    assert len(signal.run.time) == 600 and signal.displacement_noise > 0


def test_a_fit_leaves_nothing_of_what_it_says_itself():
    chosen, bench, true, rival = seen()
    own, others = (left(chosen, bench, PLANS, true, fit) for fit in (true, rival))
    assert np.all(own < 1e-2 * others) and np.all(others > 10)


def test_what_a_rival_would_leave_is_what_it_does_leave_once_that_is_recorded():
    """The linearised model against a refit to all three runs, those of the plan free of noise."""
    chosen, bench, true, rival = seen()
    problem, model = chosen.problem, chosen.model
    promised = left(chosen, bench, PLANS, true, rival)
    for plan, wanted in zip(PLANS, promised, strict=True):
        (signal,) = recorded(problem, model, true, [plan])
        run = dataclasses.replace(signal.run, file="planned.csv")
        stated: DataSet = dataset(*(each.run for each in problem.chosen), run)
        more, whole = laid_out(stated)
        points = [
            dataclasses.replace(
                fit.point, by_run=more.alike(3), own=np.asarray(whole.lanes.start), keys=rival.point.keys
            )
            for fit in (true, rival)
        ]
        points = all_settled(more, whole, points)
        one, other = refit(more, whole, points, [true.free, rival.free], wander=False)
        found = float(np.sum(other.cost - one.cost)) - float(np.sum(rival.cost - true.cost))
        assert wanted == pytest.approx(found, rel=0.05)


@pytest.mark.parametrize(
    ("verdict", "explanations", "named", "classes", "open_ones"),
    [
        ("ambiguous", {"a": 0.5, "b": 0.4, "c": 0.02}, ("a", "b"), {}, [("a",), ("b",)]),
        ("ambiguous", {"a": 0.5, "b": 0.4}, ("a", "b"), {("a",): ("b",)}, None),
        ("several", {"a+b": 0.5, "c+a": 0.48, "a": 0.01}, ("a", "b", "c"), {}, [("a", "b"), ("c", "a")]),
        ("several", {"a+b": 0.9, "c+a": 0.01}, ("a", "b"), {}, None),
        ("ambiguous", {"a": 0.5, "b": 0.4}, ("a", "never refitted"), {}, None),
        ("effect", {"a": 0.9, "b": 0.01}, ("a",), {}, None),
        ("none", {"a": 0.1}, (), {}, None),
    ],
)
def test_what_a_verdict_leaves_open(verdict, explanations, named, classes, open_ones):
    listed = [types.SimpleNamespace(keys=tuple(name.split("+"))) for name in explanations]
    found: Any = types.SimpleNamespace(
        judgement=Judgement(explanations, {}, verdict, named, {}, classes), explanations=listed
    )
    got = rivals(found)
    assert (got and [each.keys for each in got]) == open_ones


def test_a_run_is_proposed_in_words():
    plan = Plan(1.25, 4.3e-3, by_force=False)
    said = proposed(Proposal(plan, 1, 5.1, 1.2), "a", "b")
    assert said.startswith("A run at 1.25 Hz with 4.3 mm of base amplitude, as long as those recorded,")
    assert said.endswith("would set a and b 5.1 standard deviations apart (1.2 so far)")
    by_force = proposed(Proposal(Plan(2.0, 9.0, by_force=True), 3, TELLING, 0.0), "a", "b")
    assert "with 9 N of force amplitude, 3 times as long as those recorded," in by_force
    for far in (Proposal(plan, MOST_TIMES + 1, 3.4, 0.0), Proposal(plan, 1, TELLING - 0.1, 0.0)):
        assert proposed(far, "a", "b").startswith("No run of other frequency or amplitude near")
