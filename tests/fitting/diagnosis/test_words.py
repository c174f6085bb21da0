"""The verdict in words."""

from __future__ import annotations

import types

import numpy as np
import pytest

from fitting.diagnosis.judge import Judgement
from fitting.diagnosis.words import sentence, stiller
from jaxstick.catalogue import catalogue

ONE, OTHER, ALIAS = "constant_force", "base_delay", "base_relative_damping"


@pytest.mark.parametrize("likely", [0.48, 0.3])
def test_what_may_act_in_the_place_of_one_of_two_is_said(diagnosis, likely):
    """And not what is far less likely there."""
    model = types.SimpleNamespace(shelf=types.SimpleNamespace(effects=catalogue()))
    explanations = {f"{ONE}+{OTHER}": 0.5, f"{ALIAS}+{ONE}": likely, ALIAS: 0.05, "none": 0.0}
    named = (ONE, OTHER, ALIAS) if likely > 0.4 else (ONE, OTHER)
    judgement = Judgement(explanations, {}, "several", named)
    said = sentence(model, judgement, diagnosis.closure, diagnosis.where)  # pyright: ignore[reportArgumentType]
    assert said.startswith(f"{ONE} (") and f" and {OTHER} (" in said and "act together" in said
    assert (f"in the place of {OTHER} these records would have {ALIAS} (" in said) == (likely > 0.4)


def test_wandering_that_takes_over_an_effect_is_said():
    drift, level = "friction_drift", np.array([0.05, 0.0])
    (said,) = stiller((drift,), level, 0.4 * level)
    assert said.startswith(
        "Friction wanders from segment to segment by 2 % (standard deviation) with " + drift
    )
    assert "by 5 % without" in said
    assert stiller((drift,), level, 0.8 * level) == stiller((drift,), 0.05 * level, 0.01 * level) == []
