"""The records of several blind runs counted together."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from fitting.blind_score.score import scored
from jaxstick.output import to_json
from scripts.blind_totals import main
from tests.fitting.blind import stub


@pytest.fixture
def printed(tmp_path):
    """Two records: one effect of three is named in tier A and one of one in tier C; none is found in B."""
    named = stub.content("effect", "cubic_stiffness")
    missed = stub.judged(stub.answer("single", "end_stop"), named)
    found = stub.judged(stub.answer("single", "cubic_stiffness"), named)
    in_c = stub.judged(stub.answer("single", "cubic_stiffness", tier="C"), named)
    free = stub.judged(stub.answer("none", tier="B"), stub.content("none"))
    files = []
    for number, cases in enumerate(([found, missed, free], [missed, in_c])):
        files.append(tmp_path / f"{number}.json")
        files[-1].write_text(to_json(scored(cases, {}, {"seal": {"sha256": "ab"}, "cases": {}})))
    done = CliRunner().invoke(main, [str(file) for file in files])
    assert done.exit_code == 0, done.output
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in done.output.splitlines()]
    return {line[0]: line[1:] for line in lines}


def test_hits_are_counted_over_all_records(printed):
    assert printed["figure"] == ["asked for", "all", "A and B", "C"]
    asked, whole, ab, c = printed["one effect: named first"]
    assert asked == "≥ 95 %"
    assert whole == "2 of 4 = 50.0 % (6.8 to 93.2)"
    assert ab == "1 of 3 = 33.3 % (0.8 to 90.6)"
    assert c == "1 of 1 = 100.0 % (2.5 to 100.0)"
    assert printed["no effect: called none"][1:] == ["1 of 1 = 100.0 % (2.5 to 100.0)"] * 2 + ["-"]


def test_means_weigh_every_case_alike(printed):
    """Two records of unlike size: the mean over cases, not over records."""
    _, whole, ab, c = printed["one effect: mean probability of the truth and its exact aliases"]
    assert float(whole) == pytest.approx((3 * float(ab) + float(c)) / 4, abs=2e-3)
    assert float(ab) != float(c)


def test_what_no_record_has_is_left_out(printed):
    assert not any(title.startswith("two effects") for title in printed)
