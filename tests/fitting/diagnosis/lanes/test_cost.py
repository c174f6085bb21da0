"""What lanes cost."""

from __future__ import annotations

import numpy as np
import pytest

from fitting.diagnosis.lanes.cost import significance


@pytest.mark.parametrize("many", [10, 1000])
def test_what_one_lane_has_alone_comes_to_one_standard_deviation(many: int) -> None:
    alone = np.zeros(many)
    alone[3] = 5.0
    assert significance(alone) == pytest.approx(1.0, rel=0.06)


def test_what_all_lanes_have_grows_with_the_root_of_their_number() -> None:
    excess = np.tile([0.5, 1.5], 50)
    assert significance(excess) == pytest.approx(np.sqrt(100) * np.mean(excess) / np.std(excess))
    assert significance(-excess) == -significance(excess)
