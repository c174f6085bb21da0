"""How sure the constants are, in runs that rub alike and in runs that do not."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from fitting.diagnosis.lanes.layout import LEVELLED
from fitting.diagnosis.refits.confidence import Deviations, deviations
from fitting.diagnosis.words import differing
from jaxstick.parts.drive import SineDrive
from tests.fitting.diagnosis.grounded import from_the_truth, laid_out
from tests.fitting.reference_data import RIGHT, TRUTH, WRONG, dataset, noisy, own_run

LEVELS = (0.09, -0.06, -0.03)


def of_runs(*levels: float) -> tuple[dict[str, float], Deviations]:
    """Half widths of the constants' intervals (logarithms), fitted to runs of the 1987 rig whose friction
    lies so far (logarithms) from the true one."""
    random = np.random.default_rng(5)
    runs = []
    for number, level in enumerate(levels):
        scaled = {name: getattr(RIGHT, name) * math.exp(level) for name in LEVELLED}
        own = own_run(
            SineDrive(0.9 + 0.6 * number, 10.325e-3),
            constants=dataclasses.replace(RIGHT, **scaled),
            samples=500,
            file=f"run-{number}.csv",
        )
        runs.append(noisy(own, random))
    model, bench = laid_out(dataset(*runs, assumed=WRONG))
    fit = from_the_truth(model, bench, (), model.origin(TRUTH))
    found = deviations(model, bench, fit)
    half = {}
    for number, spread in zip(fit.free.tolist(), found.spread.tolist(), strict=True):
        member, at = model.members[number], fit.point.coordinates[number]
        high, low = (member.to_value(at + way * found.quantile * spread) for way in (1, -1))
        if low > 0:
            half[model.names[number]] = math.log(high / low) / 2
    return half, found


def test_constants_are_known_no_better_than_runs_agree():
    """A and C as well as three runs tell the typical one, and what each is known to; B and k1 as before."""
    alike, same = of_runs(0.0, 0.0, 0.0)
    apart, found = of_runs(*LEVELS)
    assert found.between_runs == pytest.approx(float(np.std(LEVELS, ddof=1)), rel=0.05)
    assert same.between_runs < 0.05 * found.between_runs
    half = 4.303 * found.between_runs / math.sqrt(3)
    assert apart["C"] == pytest.approx(half, rel=0.05)
    assert apart["A"] == pytest.approx(math.hypot(half, alike["A"]), rel=0.1)
    for name in ("B", "k1"):
        assert apart[name] == pytest.approx(alike[name], rel=0.3)


def test_it_is_said_where_runs_differ():
    (words,) = differing(0.078, 6)
    assert "7.8 %" in words and "6 runs" in words
    assert differing(0.004, 6) == []
