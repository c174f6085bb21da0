"""What every anomaly says: what is seen, where that lies, and what to do next."""

from __future__ import annotations

import pytest

from fitting.diagnosis.unlisted.anomaly import AbstractAnomaly
from fitting.diagnosis.unlisted.bad_samples import BadSamples
from fitting.diagnosis.unlisted.bursts import Bursts
from fitting.diagnosis.unlisted.constancy import Trend
from fitting.diagnosis.unlisted.held_samples import HeldSamples
from fitting.diagnosis.unlisted.jumps import Jumps
from fitting.diagnosis.unlisted.own_beat import OwnBeat
from fitting.diagnosis.unlisted.unrest import Unrest

SEEN = {
    "measurement": (BadSamples(9, 5, 6, 1e-4), HeldSamples("friction force", "N", 7, 3, 6, 0.25)),
    "friction": (Bursts(5, 6, 0.023, 0.12), Jumps(9, 5, 6, 0.023)),
    "mechanics": (OwnBeat(16.61, 5, 6, friction_known=True),),
    None: (
        OwnBeat(16.61, 5, 6, friction_known=False),
        Trend("late_force", "late_force (a late force)", 400.0, 23.0, grows=True),
        Unrest(0.012),
    ),
}
EACH = [(side, anomaly) for side, anomalies in SEEN.items() for anomaly in anomalies]


def test_all_of_them_are_here():
    assert {type(anomaly) for _, anomaly in EACH} == set(AbstractAnomaly.__subclasses__())


@pytest.mark.parametrize(("side", "seen"), EACH, ids=[f"{type(seen).__name__}-{side}" for side, seen in EACH])
def test_what_it_says(side, seen):
    assert seen.clause[0].islower() and not seen.clause.endswith(".")
    assert seen.look[0].isupper() and seen.look.endswith(".")
    assert seen.note is None or seen.note.endswith(".")
    if side is None:
        assert seen.sides is None
    else:
        assert set(seen.sides) == {"mechanics", "friction", "measurement"}
        assert seen.sides[side] == sum(seen.sides.values()) == 1.0
