"""What runs that took no part say of what is named."""

from __future__ import annotations

import dataclasses

import pytest

from fitting.diagnosis.findings import Closure
from fitting.diagnosis.shrink import left_open, refutes, worsens

CLOSED = Closure(6.6, 1.1, 1.0, 14.0, 0.98, (0.95, 1.0), -0.02, 0.4, ("run-02.csv",), False)


@pytest.mark.parametrize(
    ("before", "floor", "closed", "interval", "refuted"),
    [
        (6.6, 1.0, 0.98, (0.95, 1.0), False),
        (6.6, 1.4, 0.12, (0.07, 0.17), True),
        (4.4, 1.0, -0.80, (-1.2, -0.41), True),
        (6.6, 1.0, 0.12, (-0.30, 0.55), False),
        (1.2, 1.0, 0.00, (-0.10, 0.10), False),
        (6.6, 5.9, 0.00, (-0.10, 0.10), False),
    ],
    ids=["closed", "open", "wider", "uncertain", "no gap", "a gap that nothing closes"],
)
def test_a_gap_that_stays_open_refutes(before, floor, closed, interval, refuted):
    shrunk = dataclasses.replace(CLOSED, before=before, floor=floor, closed=closed, interval=interval)
    assert refutes(shrunk) is refuted


@pytest.mark.parametrize(
    ("before", "after", "worse"),
    [(0.990, 0.994, True), (0.994, 0.990, False), (1.4, 1.41, True), (6.6, 6.7, False)],
    ids=["noise, more of it", "noise, less of it", "hardly a gap", "a gap"],
)
def test_what_makes_noise_no_less_worsens(before, after, worse):
    """A gap that stays open is another matter."""
    assert worsens(dataclasses.replace(CLOSED, before=before, after=after)) is worse


def test_with_nothing_named_nothing_closes():
    shrunk = left_open(CLOSED)
    assert (shrunk.before, shrunk.floor, shrunk.assumed) == (CLOSED.before, CLOSED.floor, CLOSED.assumed)
    assert (shrunk.after, shrunk.closed, shrunk.interval) == (CLOSED.before, 0.0, (0.0, 0.0))
    assert shrunk.placebo is None and shrunk.wrong is None
