"""Sizes of units, the signature of an effect, and the command that draws it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from jaxstick.catalogue import catalogue
from jaxstick.cli import jaxstick
from jaxstick.parameter import parameters
from jaxstick.signature import DRIVE, SAMPLES_PER_CYCLE, signature
from jaxstick.sizes import size_of

KEY = "position_dependent_friction"


@pytest.mark.parametrize(
    ("unit", "size"),
    [
        ("1", 1.0),
        ("N", 7.0),
        ("1/m", 1 / 0.01),
        ("N/m^3", 7.0 / 1e-6),
        ("N s/m", 7.0 * 0.2 / 0.01),
        ("N s^2/m^2", 7.0 * 0.04 / 1e-4),
        ("kg", 7.0 * 0.04 / 0.01),
        ("Hz", 5.0),
        ("rad", 1.0),
    ],
)
def test_a_unit_amounts_to_its_product_of_scales(unit: str, size: float) -> None:
    assert size_of(unit, 7.0, 0.01, 0.2) == pytest.approx(size)


def test_a_unit_that_is_not_made_of_these_is_refused() -> None:
    with pytest.raises(ValueError, match=r"'V/m' is not made of N, m, s"):
        size_of("V/m", 1.0, 1.0, 1.0)


def test_every_strength_on_the_shelf_has_a_size() -> None:
    for key, effect in catalogue().items():
        for place in parameters(effect()):  # pyright: ignore[reportCallIssue]
            kind = place.parameter
            assert kind.typical is None or kind.typical > 0, (key, place.path)
            assert kind.typical is not None or kind.null is None, (key, place.path)
            assert size_of(kind.unit, 7.0, 0.01, 0.2) > 0


def test_the_signature_is_a_cycle_with_and_without() -> None:
    seen = signature(KEY)
    amplitude = float(DRIVE.base_amplitude)
    assert seen.values == {
        "gradient": (pytest.approx(0.1 / amplitude), "1/m"),
        "length": (pytest.approx(2 * amplitude), "m"),
    }
    for run in (seen.without, seen.with_effect):
        assert len(np.asarray(run.x)) == SAMPLES_PER_CYCLE + 1
        assert np.ptp(np.asarray(run.time)) == pytest.approx(1 / float(DRIVE.frequency))
    slip = np.abs(np.asarray(seen.without.v)) > 0.05
    ratio = np.asarray(seen.with_effect.friction)[slip] / np.asarray(seen.without.friction)[slip]
    place = 2 * amplitude * np.tanh(np.asarray(seen.with_effect.x)[slip] / (2 * amplitude))
    slope = np.polyfit(place, ratio, 1)[0]
    assert slope == pytest.approx(seen.values["gradient"][0], rel=0.3)


def test_the_command_draws_the_effect_that_is_named(tmp_path) -> None:
    folder = tmp_path / "card"
    done = CliRunner().invoke(jaxstick, ["effects", KEY, "--out", str(folder), "--json"])
    assert done.exit_code == 0, done.stderr
    assert (folder / f"{KEY}.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((folder / f"{KEY}.json").read_text()) == json.loads(done.stdout)
    again = CliRunner().invoke(jaxstick, ["effects", KEY, "--out", str(folder)])
    assert again.exit_code == 2 and str(folder) in again.stderr


def test_the_shelf_as_a_whole_is_not_drawn(tmp_path) -> None:
    refused = CliRunner().invoke(jaxstick, ["effects", "--out", str(tmp_path / "shelf")])
    assert refused.exit_code == 2 and "jaxstick effects KEY --out DIR" in refused.stderr
    assert not (tmp_path / "shelf").exists()
