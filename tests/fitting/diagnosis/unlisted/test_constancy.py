"""An effect that changes along the runs is told from one that does not, and from none."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fitting.diagnosis.refits.refit import refit
from fitting.diagnosis.unlisted.constancy import NOTABLE, Trend, trend_of
from jaxstick.catalogue import catalogue
from jaxstick.parts.drive import SineDrive
from jaxstick.record import Run
from tests.fitting.diagnosis.grounded import from_the_truth, grounded_on, laid_out
from tests.fitting.reference_data import TRUTH, dataset, noisy, own_run

LATE, CLOCK = 8e-3, 2e-3
"""A delay of the force [s], and one that grows by so much a second."""
VERY_LATE, HARDLY = 12e-3, 2e-4
"""One that is long, and changes by a small part of itself from the beginning of the runs to their end."""
KEY = "force_delay"


def delayed(run: Run, delay: float, rate: float) -> Run:
    """The run with its friction force read late, and later and later."""
    assert run.friction is not None
    late = run.time - delay - rate * run.time
    return dataclasses.replace(run, friction=np.interp(late, run.time, run.friction))


@pytest.fixture(
    scope="module",
    params=[(0.0, 0.0), (LATE, 0.0), (0.0, CLOCK), (LATE, -CLOCK), (VERY_LATE, HARDLY)],
    ids=["none", "still", "growing", "shrinking", "hardly"],
)
def late(request: pytest.FixtureRequest) -> tuple[float, Trend | None, Trend | None]:
    """By how much a second the force of some runs is later; what changes with the nominal model, and with the
    delay named."""
    delay, rate = request.param
    random, runs = np.random.default_rng(7), []
    for frequency in (0.9, 1.5, 2.1):
        run = own_run(SineDrive(frequency, 10.325e-3), samples=1600, file=f"run-{frequency}.csv")
        runs.append(noisy(delayed(run, delay, rate), random))
    _, model, base = grounded_on(runs)
    bench, constants = base.bench, model.index(*model.constants)
    (nominal,) = refit(model, bench, [base.point], [constants])
    point = dataclasses.replace(nominal.point, keys=model.sharing.together((KEY,)))
    (named,) = refit(model, bench, [point], [np.concatenate([constants, model.of(KEY)])])
    unnamed = trend_of(model, bench, nominal, (KEY, "force_gain", "quadratic_drag"))
    return rate, unnamed, trend_of(model, bench, named, (KEY,))


def test_a_delay_that_changes_is_seen_to_whether_it_is_named_or_not(late):
    """And one that does not, or none, is not; nor one that changes by little, where it is named."""
    rate, unnamed, named = late
    if rate in (0.0, HARDLY):
        assert named is None and (unnamed is None or rate == HARDLY)
        return
    for trend in (unnamed, named):
        assert trend is not None and trend.key == KEY and trend.grows == (rate > 0)
        assert trend.gain > NOTABLE and trend.evidence > 12
        assert trend.title.startswith(f"{KEY} (force")


def test_what_leaves_no_trace_does_not_change():
    """A fault of the force sensor where no force was recorded."""
    run = dataclasses.replace(own_run(SineDrive(1.5, 10.325e-3), samples=600), friction=None)
    model, bench = laid_out(dataset(run))
    fit = from_the_truth(model, bench, model.sharing.together((KEY,)), model.origin(TRUTH))
    assert trend_of(model, bench, fit, (KEY,)) is None


def test_what_changes_by_itself_is_not_tested():
    """Nor a wrong zero of the force: one that drifts is on the shelf."""
    for key in ("force_offset", "force_drift", "force_highpass", "friction_drift"):
        assert catalogue()[key].changes
    assert not catalogue()[KEY].changes
    run = own_run(SineDrive(1.5, 10.325e-3), samples=600)
    model, bench = laid_out(dataset(run))
    fit = from_the_truth(model, bench, (), model.origin(TRUTH))
    assert trend_of(model, bench, fit, ("force_offset", "friction_drift")) is None


def test_it_says_what_would_have_to_change_and_which_way():
    grows = Trend(KEY, f"{KEY} (late force)", 400.0, 23.0, True)
    assert grows.clause.startswith(f"what looks like {KEY} (late force) changes from the beginning")
    assert grows.note.startswith(f"{KEY} would have to grow along the runs (chi-square 23 by segments")
    assert "have to shrink" in dataclasses.replace(grows, grows=False).note
