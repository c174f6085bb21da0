"""What an explanation is judged by."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fitting.diagnosis.attribute import account

FLOOR = 1.1


def left(misfit: float, *keys: str, scatters: bool) -> float:
    """The misfit that is counted for an explanation by these effects, in units of the floor."""
    model: Any = SimpleNamespace(of=lambda _: np.array([0]), by_run=np.zeros(0, int))
    bench: Any = SimpleNamespace(run=np.array([0, 0, 1]), wanders=False, scatters=scatters)
    found: Any = SimpleNamespace(keys=keys, refit=SimpleNamespace(misfit=misfit))
    nominal: Any = None
    return account(model, bench, nominal, found, FLOOR).misfit


def test_a_second_effect_cannot_go_below_what_was_weighed_by():
    """Where that is the noise of the sensors, which may be overrated, and for one effect, it is no bound."""
    assert left(0.9, "one", "other", scatters=True) == 1.0
    assert left(1.65, "one", "other", scatters=True) == pytest.approx(1.5)
    assert left(0.9, "one", scatters=True) == left(0.9, "one", "other", scatters=False) == 0.9 / FLOOR
