"""Friction that scatters within segments is told from friction that wanders."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from fitting.diagnosis.noise.scatter import Scatter
from fitting.diagnosis.unlisted.unrest import Unrest, unrest


@pytest.mark.parametrize(
    ("times", "widths", "noise", "said"),
    [
        (12.0, (1e-6, 1e-6), 0.06, True),
        (12.0, (0.05, 0.01), 0.06, False),
        (12.0, (0.05, 0.01), 0.6, True),
        (1.4, (1e-6, 1e-6), 0.06, False),
        (12.0, (1e-6, 1e-6), None, False),
    ],
)
def test_friction_that_wanders_does_so_from_segment_to_segment_too(times, widths, noise, said):
    """Unless it forgets from one sample to the next; noise alone does not count, nor do missing records."""
    scatter = Scatter({"stick": (1.0, 1.1), "slip": (50.0, times**2)}, None, 0.2)
    problem: Any = SimpleNamespace(chosen=[SimpleNamespace(friction_noise=noise)])
    model: Any = SimpleNamespace(values=lambda coordinates, names: {"A": 1.5, "C": 6.0})
    nominal: Any = SimpleNamespace(misfit=1.0, point=SimpleNamespace(coordinates=None, widths=widths))
    found = unrest(problem, model, nominal, scatter)
    assert (found is not None) is said
    assert unrest(problem, model, nominal, None) is None


def test_it_says_how_little_friction_wanders():
    assert "which changes by 0.012 % only from segment to segment" in Unrest(0.012).clause
    assert Unrest(0.012).note is None
