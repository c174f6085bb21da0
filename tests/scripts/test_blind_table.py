"""The record of a blind run as tables."""

from __future__ import annotations

from click.testing import CliRunner

from fitting.blind_score.score import scored
from jaxstick.output import to_json
from scripts.blind_table import main
from tests.fitting.blind import stub


def test_every_row_has_the_columns_of_its_table(tmp_path):
    named = stub.content("effect", "cubic_stiffness")
    cases = [
        stub.judged(stub.answer("single", "cubic_stiffness"), named),
        stub.judged(stub.answer("single", "end_stop", tier="B"), named),
    ]
    (tmp_path / "score.json").write_text(to_json(scored(cases, {}, {"seal": {"sha256": "ab"}, "cases": {}})))
    done = CliRunner().invoke(main, [str(tmp_path / "score.json")])
    assert done.exit_code == 0, done.output
    answers, further, effects = done.output.strip().split("\n\n")
    for table in (answers, further, effects):
        lines = table.split("\n")
        assert len({line.count("|") for line in lines}) == 1 and len(lines) > 2
    assert answers.split("\n")[0].startswith("| figure | all | A | B |")
    assert "| cubic_stiffness | mechanics | 1 | 100 % (2.5 to 100) |" in effects
    assert "| end_stop | mechanics | 1 | 0.0 % (0.0 to 97.5) |" in effects
