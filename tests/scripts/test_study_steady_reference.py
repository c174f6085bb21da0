"""The comparison of periodic states with the marched reference, on two quick lanes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from jaxstick.steady import periodic_states
from scripts import study_steady_reference as study
from scripts.study_steady import of_1987

RATIOS = np.array([0.6, 0.9])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("references")
    for lane, ratio in enumerate(RATIOS):
        study.march(folder, lane, float(ratio))
    return folder


def test_the_same_motions_are_called_so_and_others_not(folder: Path) -> None:
    all_ = study.references(folder, RATIOS, 1)
    laps = of_1987(RATIOS, "loaded")
    states = periodic_states(laps)
    ours = study.motions(laps, states)
    for lane, reference in enumerate(all_):
        assert reference.period() == 1
        assert study.apart(ours[lane], reference.x) < 3e-5
        assert study.verdict(states, lane, ours[lane], reference) == "same motion"
        assert study.we_stay(reference) < 3e-5
        assert study.reference_stays(states, lane, reference.ratio, ours[lane]) < 3e-5
    assert study.apart(ours[0], all_[1].x) > 0.1
    assert study.verdict(states, 0, 1.01 * ours[0], all_[0]).startswith("another motion")


def test_files_that_are_there_are_not_marched_again(folder: Path) -> None:
    before = [file.stat().st_mtime_ns for file in sorted(folder.iterdir())]
    study.references(folder, RATIOS, 1)
    assert [file.stat().st_mtime_ns for file in sorted(folder.iterdir())] == before
    with pytest.raises(ValueError, match="another sweep"):
        study.references(folder, RATIOS[::-1], 1)
