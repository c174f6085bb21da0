"""Single samples that are off in more than one run are no effect of the shelf."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.unlisted.bad_samples import bad_samples

TIME = np.arange(600) / 250


def recorded(bad: int, seed: int) -> Any:
    """One run with so many samples off by 1.5 mm."""
    signal = 5e-3 * np.sin(8 * TIME) + 5e-6 * np.random.default_rng(seed).standard_normal(600)
    signal[20 : 20 + 15 * bad : 15] -= 1.5e-3
    return SimpleNamespace(run=SimpleNamespace(displacement=signal))


@pytest.mark.parametrize(
    ("bad", "said"),
    [((0, 0, 0), None), ((9, 0, 0), None), ((1, 1, 0), None), ((3, 3, 0), (6, 2)), ((2, 2, 2), (6, 3))],
)
def test_a_few_or_those_of_one_run_are_an_accident(
    bad: tuple[int, ...], said: tuple[int, int] | None
) -> None:
    problem: Any = SimpleNamespace(chosen=[recorded(count, seed) for seed, count in enumerate(bad)])
    found = bad_samples(problem)
    assert (None if found is None else (found.count, found.runs)) == said
    if found is not None:
        assert found.of == 3 and found.most == pytest.approx(1.5e-3, abs=3e-5)
        assert f"In {found.runs} of 3 runs" in found.note and "by up to 1.5" in found.clause
