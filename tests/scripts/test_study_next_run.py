"""A proposed run beside those of a sealed case."""

from __future__ import annotations

import pytest

from fitting.blind.case import Assignment, draw_case
from fitting.blind.folder import write_case
from fitting.blind.making import settings_of
from jaxstick.record import load_dataset
from scripts.study_next_run import with_run


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_run_is_added_and_the_others_stay_as_they_were(tmp_path, number):
    settings = settings_of("development", 5, 2, 900, "strong")
    recipe, answer = draw_case(settings, number, Assignment("single", "A", ("force_delay",)))
    write_case(recipe, tmp_path / "before")
    proposal = {"frequency_hz": 1.5 * recipe.runs[0].frequency, "base_amplitude_m": 1e-3, "times_as_long": 2}
    with_run(answer, proposal, tmp_path / "after")
    before, after = (load_dataset(tmp_path / name) for name in ("before", "after"))
    for one, other in zip(before.runs, after.runs, strict=False):
        assert (tmp_path / "before" / one.file).read_bytes() == (tmp_path / "after" / other.file).read_bytes()
        assert one.frequency == other.frequency
    assert len(before.runs) == 2 and len(after.runs) == 3
    added = after.runs[-1]
    assert len(added.time) == 2 * recipe.runs[0].samples
    if added.frequency is not None:
        assert added.frequency == pytest.approx(proposal["frequency_hz"], rel=1e-4)
    if added.base is not None:
        assert 0.5 * (added.base.max() - added.base.min()) == pytest.approx(1e-3, rel=0.02)
    with_run(answer, proposal, tmp_path / "after")
