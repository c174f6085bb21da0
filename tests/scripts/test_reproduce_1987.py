"""The reproduction of the 1987 paper: its conditions, its judgement of made-up curves, its page."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from scripts import reproduce_1987
from scripts.paper1987 import claims, conditions, states
from scripts.paper1987.states import Curve
from tests.reference import rig1987

RATIOS = np.geomspace(0.04, 0.98, 300)
BORDERS = {2: 0.46, 4: 0.22, 6: 0.117, 8: 0.075, 10: 0.055}


def made_up(shift: float = 1.0, label: str = "made up") -> Curve:
    """A curve whose stops change at BORDERS times `shift`, with a minimum at every change but the last."""
    stops = sum(2.0 * (shift * place > RATIOS) for place in BORDERS.values())
    bumps = sum(
        -0.2 * np.exp(-((np.log(RATIOS / (shift * place)) / 0.03) ** 2))
        for number, place in BORDERS.items()
        if number > 2
    )
    small = np.full_like(RATIOS, 1e-10)
    return Curve(label, RATIOS, 0.8 + bumps + RATIOS**2, np.asarray(stops), small, small)


def test_the_conditions_are_those_of_the_independent_model():
    rig = conditions.rig()
    assert rig.damping == pytest.approx(rig1987.DAMPING)
    assert rig.natural_frequency == pytest.approx(rig1987.NATURAL_FREQUENCY)
    assert pytest.approx(rig1987.STATIC_FRICTION, rel=1e-3) == conditions.STATIC_FRICTION
    assert dict(zip(conditions.RATIOS, conditions.STOPS, strict=True)) == rig1987.STOPS
    assert conditions.base_amplitude(*conditions.DRIVES[1]) == pytest.approx(rig1987.BASE_AMPLITUDE)
    friction = conditions.constants()
    assert pytest.approx(0.86 * conditions.STATIC_FRICTION) == friction.C
    assert (friction.A or 0) + (friction.C or 0) == pytest.approx(conditions.STATIC_FRICTION)


def test_changes_and_minima_are_found_where_they_are():
    found = claims.changes(made_up())
    assert {change.below: change.meets for change in found} == {2: False, 4: True, 6: True, 8: True, 10: True}
    for change in found:
        assert change.place == pytest.approx(BORDERS[change.below], rel=0.01)
    assert claims.other_minima(made_up()) == []
    finding = claims.minima_at_changes([made_up()])
    assert finding.verdict == claims.PARTLY
    assert finding.found.startswith("4 of 5 changes") and "2 to 0 on 1 of the curves" in finding.found


def test_a_shift_is_judged_by_every_change():
    up = [made_up(), made_up(1.05), made_up(1.1)]
    assert claims.shift("claim", up, "what").verdict == claims.AGREES
    assert claims.shift("claim", up[::-1], "what").verdict == claims.DIFFERS
    assert claims.shift("claim", up[::-1], "what", upwards=False).verdict == claims.AGREES
    assert "goes nowhere" in claims.shift("claim", [up[0], made_up(1.005)], "what").found
    assert "both ways" in claims.shift("claim", [up[0], up[2], up[1]], "what").found


def test_odd_and_unclear_stops_are_counted():
    flicker = made_up()
    flicker = replace(flicker, stops=np.where(np.arange(300) % 10 == 3, np.nan, flicker.stops))
    low = claims.clearness([flicker, made_up()])
    assert low.verdict == claims.AGREES and "beyond the steps from region to region: " in low.found
    assert "0 (made up)." in low.found
    odd = replace(made_up(), stops=np.where(RATIOS < 0.05, 9.0, made_up().stops))
    assert f" {np.sum(RATIOS < 0.05)} of 300 states" in claims.odd_stops(odd, made_up(), 10.0).found


def test_the_drives_are_held_against_the_exciter():
    finding = claims.drives_within_reach()
    assert finding.verdict == claims.DIFFERS
    assert "18.2, 20.6, 43.9 mm" in finding.found


@pytest.fixture(scope="module")
def motion() -> states.Response:
    """At 0.19, with four stops."""
    return states.responses(conditions.rig(), conditions.constants(), (0.19,), 10.325e-3)[0]


def test_a_response_has_the_stops_of_figure_7(motion):
    assert motion.stops == 4
    third, fifth = motion.harmonics[[2, 4]] / motion.harmonics[0]
    assert third == pytest.approx(0.100, abs=0.005) and fifth == pytest.approx(0.126, abs=0.005)


def test_the_page_holds_everything_itself(motion, tmp_path, monkeypatch):
    """Of made-up curves and one real motion: ten pictures, all findings, nothing to fetch."""

    def curve(label, rig, constants, ratios, amplitude):
        return replace(made_up(), label=label)

    def five(*args, ratios, friction_ratio=(0,), **options):
        lanes = len(np.atleast_1d(friction_ratio)) * len(ratios)
        return {
            "stops": np.resize(np.array(conditions.STOPS, float), lanes),
            "period": np.ones(lanes, int),
            **{name: np.full(lanes, 1e-3) for name in ("residual", "multiplier", "amplitude_m")},
        }

    motions = [replace(motion, ratio=ratio) for ratio in conditions.RATIOS]
    monkeypatch.setattr(reproduce_1987, "curve", curve)
    monkeypatch.setattr(reproduce_1987, "sweep", five)
    monkeypatch.setattr(claims, "sweep", five)
    monkeypatch.setattr(reproduce_1987, "responses", lambda *args: motions)
    out = tmp_path / "page.html"
    result = CliRunner().invoke(reproduce_1987.main, ["--out", str(out), "--points", "300"])
    assert result.exit_code == 0, result.output
    page = out.read_text(encoding="utf-8")
    assert page.count('src="data:image/png;base64,') == 10
    assert not re.search(r"(src|href)=[\"'](?!data:)", page)
    for number in range(4, 11):
        assert f"figure {number}" in page
    assert result.output.count("\n    ") == page.count('class="verdict"') == 14
    assert "misprint" in page and "lost" in page and "differs" in page
